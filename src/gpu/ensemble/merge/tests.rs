use super::*;

fn validated(text: &str) -> (Module, naga::valid::ModuleInfo) {
    let module = naga::front::wgsl::parse_str(text).unwrap();
    let info = checked(&module).unwrap();
    (module, info)
}

fn checked(module: &Module) -> Result<naga::valid::ModuleInfo, String> {
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
    validator.validate(module).map_err(|e| format!("{e:?}"))
}

const TEXT: &str = "
struct Parameters { n: u32, by: f32, a: u32, b: u32 }
struct Report { most: atomic<u32>, least: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> sources: array<f32>;
@group(0) @binding(2) var<storage, read_write> into: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> report: Report;
@group(0) @binding(4) var<storage, read_write> counts: array<atomic<u32>, 2>;
var<workgroup> shared_sum: array<f32, 8>;
fn scaled(i: u32) -> f32 { return sources[i] * parameters.by; }
@compute @workgroup_size(8)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    for (var i = group.x * 8u + local; i < parameters.n; i += groups.x * 8u) {
        let signed = i32(i);
        into[signed].y = scaled(i) + sources[0];
        shared_sum[local] = into[i].y;
        atomicMax(&report.most, i);
        if report.least > i { report.least = i; }
        atomicAdd(&counts[1], 1u);
    }
    workgroupBarrier();
    if local == 0u { into[0].x = shared_sum[7]; }
}
";

#[test]
fn a_merged_kernel_is_valid_and_binds_the_table_its_arrays_the_arena_and_its_parameters() {
    let (module, info) = validated(TEXT);
    let merged = merged(&module, &info).unwrap();
    checked(&merged.module).unwrap();
    assert_eq!((merged.strides, merged.parameters), (vec![4, 16, 8, 4], Some(16)));
    let mut bound: Vec<_> = merged
        .module
        .global_variables
        .iter()
        .filter_map(|(_, variable)| Some((variable.binding?.binding, variable.name.clone()?)))
        .collect();
    bound.sort();
    let names: Vec<&str> = bound.iter().map(|(_, name)| name.as_str()).collect();
    assert_eq!(names, ["members", "sources", "into", "report", "counts", "arena", "parameters_of_all"]);
}

#[test]
fn a_kernel_that_asks_for_a_length_is_refused() {
    let text = "
        @group(0) @binding(1) var<storage, read_write> a: array<u32>;
        @compute @workgroup_size(1) fn main() { a[0] = arrayLength(&a); }";
    let (module, info) = validated(text);
    assert!(merged(&module, &info).is_err_and(|message| message.contains("length")));
}
