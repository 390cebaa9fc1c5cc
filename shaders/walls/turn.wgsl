// Sets the normals and levers of places at walls, whose gaps refer to the walls at a step's end, to those at the walls
// in its middle, where forces act. `surfaces` are those in the middle.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> surfaces: array<vec4r>;
var<storage, read_write> contacts: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = parameters.first + invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    let i = pairs[p].x;
    let body = placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]);
    let surface = surface_at(surface_of(pairs[p].y));
    let offset = offset_from(surface, cells[i].xyz, remainders[i].xyz);
    let found = separate_place(surface, offset, body, place_of(pairs[p].y));
    contacts[3u * p] = vec4r(found.normal, contacts[3u * p].w);
    contacts[3u * p + 1u] = vec4r(found.lever_a, contacts[3u * p + 1u].w);
}
