use super::*;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

const SOURCE: &str = "@group(0) @binding(0) var<uniform> n: u32;
struct Body { cell: vec2<u32>, sizes: array<f32, 4> }
@group(0) @binding(1) var<storage, read> list: array<u32>;
@group(0) @binding(3) var<storage, read_write> bodies: array<Body>;
const PLACE: u32 = 2u;
@group(0) @binding(PLACE) var<storage, read_write> out: array<vec4<f32>>;
fn first_of(i: u32) -> u32 { return list[i]; }
fn twice(i: u32) -> u32 { return 2u * first_of(i); }
@compute @workgroup_size(1) fn main() {
    out[list[list[3]] + n] = vec4<f32>(f32(list[1]));
    out[n].w = 2.0 * out[2].x;
    out[n + 1u] += out[n];
    for (var i = 0; i < 3; i += 1) {
        if list[i] == twice(4u) { out[i].y *= 2.0; continue; }
        switch list[i + 1] { case 1u: { out[1][n] = 1.0; } default: { bodies[n].sizes[i] += f32(bodies[1].cell.y); } }
    }
}
";

fn checked(module: &Module) -> ModuleInfo {
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(SOURCE)))
}

fn banked(name: &str, banks: u32) -> Banked {
    Banked { name: name.into(), banks, elements: 64 }
}

fn after(source: &str, of: &[Banked]) -> Result<Module, String> {
    let mut module = naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    let info = checked(&module);
    split(&mut module, &info, of)?;
    checked(&module);
    Ok(module)
}

/// The storage variables by their bindings.
fn storages(module: &Module) -> Vec<(u32, String)> {
    let mut found: Vec<_> = module
        .global_variables
        .iter()
        .filter(|(_, variable)| matches!(variable.space, AddressSpace::Storage { .. }))
        .map(|(_, variable)| (variable.binding.unwrap().binding, variable.name.clone().unwrap()))
        .collect();
    found.sort();
    found
}

fn names(module: &Module) -> Vec<String> {
    let mut names: Vec<String> = module.functions.iter().map(|(_, function)| function.name.clone().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_function_for_each_path_loads_and_stores() {
    let module = after(SOURCE, &[banked("list", 3), banked("out", 2)]).unwrap();
    let found = storages(&module);
    let found: Vec<_> = found.iter().map(|(number, name)| (*number, name.as_str())).collect();
    assert_eq!(found, [(1, "list"), (2, "list_1"), (3, "list_2"), (4, "out"), (5, "out_1"), (6, "bodies")]);
    // `list[1]`, `list[3]`, `list[u32]` and `list[i32]`; `out[u32]`, `out[2].x` and `out[i32].y`.
    let at = |name: &str| names(&module).iter().filter(|other| *other == name).count();
    assert_eq!([at("list_at"), at("out_at"), at("out_store"), at("first_of"), at("twice")], [4, 3, 4, 1, 1]);
}

#[test]
fn members_and_computed_parts_have_paths() {
    let module = after(SOURCE, &[banked("bodies", 4)]).unwrap();
    assert_eq!(names(&module), ["bodies_at", "bodies_at", "bodies_store", "first_of", "twice"]);
    assert_eq!(storages(&module).last().unwrap(), &(6, "bodies_3".to_owned()));
}

#[test]
fn arrays_in_one_bank_are_only_renumbered() {
    let module = after(SOURCE, &[banked("list", 4)]).unwrap();
    assert!(storages(&module).contains(&(5, "out".into())) && names(&module).iter().all(|name| name != "out_at"));
}

#[test]
fn what_has_no_function_is_refused() {
    let all = [
        "@group(0) @binding(0) var<storage, read_write> out: array<atomic<u32>>;
         @compute @workgroup_size(1) fn main() { atomicAdd(&out[1], 1u); }",
        "@group(0) @binding(0) var<storage, read_write> out: array<u32>;
         @compute @workgroup_size(1) fn main() { out[0] = arrayLength(&out); }",
    ];
    for source in all {
        after(source, &[banked("out", 2)]).unwrap_err();
    }
}
