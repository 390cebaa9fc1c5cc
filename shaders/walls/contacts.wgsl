// The separations of bodies from surfaces in the present state, each at the nearest of the body's places, for a list of
// contacts. Three vectors per pair of a body and a surface, as for a pair of bodies.

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
    let p = invocation(group, groups, local);
    if p >= parameters.count { return; }
    let i = pairs[p].x;
    let body = placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]);
    let surface = surface_at(pairs[p].y);
    let offset = offset_from(surface, cells[i].xyz, remainders[i].xyz);
    var nearest = separate_place(surface, offset, body, 0u);
    for (var place = 1u; place < PLACES; place += 1u) {
        let found = separate_place(surface, offset, body, place);
        if found.separation < nearest.separation { nearest = found; }
    }
    contacts[3u * p] = vec4r(nearest.normal, nearest.separation);
    contacts[3u * p + 1u] = vec4r(nearest.lever_a, 0.0);
    contacts[3u * p + 2u] = vec4r(nearest.lever_b, 0.0);
}
