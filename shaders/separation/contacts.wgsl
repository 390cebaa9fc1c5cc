// The separations of pairs of bodies in the present state, for a list of contacts. Three vectors per pair: (normal,
// separation), the lever of a, the lever of b.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read_write> contacts: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.count { return; }
    let a = pairs[p].x;
    let b = pairs[p].y;
    if !is_of_families(u32(shapes[a].w), u32(shapes[b].w)) { return; }
    let delta = lattice_difference(cells[a].xyz, remainders[a].xyz, cells[b].xyz, remainders[b].xyz);
    let body_a = placed(shapes[a], orientations[2u * a], orientations[2u * a + 1u]);
    let body_b = placed(shapes[b], orientations[2u * b], orientations[2u * b + 1u]);
    let found = separate(delta, body_a, body_b, vec3r(0.0, 0.0, 0.0));
    contacts[3u * p] = vec4r(found.normal, found.separation);
    contacts[3u * p + 1u] = vec4r(found.lever_a, 0.0);
    contacts[3u * p + 2u] = vec4r(found.lever_b, 0.0);
}
