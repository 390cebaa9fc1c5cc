// The places of bodies that may come near a surface while their boxes stay inside the stored ones: first counted, then
// written by the same code after the pairs of bodies.

var<storage, read> stored_cells: array<vec4<i32>>;
var<storage, read> stored_remainders: array<vec4r>;
var<storage, read> stored_boxes: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> surfaces: array<vec4r>;
// For each body: the number of places that it found, or the offset at which they are written.
var<storage, read_write> list: array<u32>;
var<storage, read_write> pairs: array<vec2<u32>>;

// The largest number of places of a shape at a surface.
fn places(kind: u32, surface: u32) -> u32 {
    switch kind {
        case SPHERE, ELLIPSOID: { return 1u; }
        case SPHEROCYLINDER: { return 2u; }
        case TORUS: { return select(3u, 1u, surface == SURFACE_CYLINDER); }
        // No such body: the host knows that its box is not finite.
        default: { return 0u; }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let half = stored_boxes[i].xyz;
    var found = 0u;
    var to = 0u;
    if parameters.fill == 1u { to = parameters.first + list[i]; }
    for (var k = 0u; k < parameters.count; k += 1u) {
        let surface = surface_at(k);
        let room = gap_of(surface, offset_from(surface, stored_cells[i].xyz, stored_remainders[i].xyz)).distance;
        // No point of the box is farther from its middle.
        var reach = length(half);
        if surface.kind == SURFACE_PLANE {
            reach = dot(abs(surface.first.unit), half);
        }
        // A box includes half the cutoff; a pair has the other half from its second body. Rounding may make the reach
        // slightly too short.
        reach += 0.5 * CUTOFF;
        if room > reach + 64.0 * EPSILON * (reach + UNIT) { continue; }
        for (var place = 0u; place < places(u32(shapes[i].w), surface.kind); place += 1u) {
            if parameters.fill == 1u {
                pairs[to + found] = vec2<u32>(i, number_of(k, place));
            }
            found += 1u;
        }
    }
    if parameters.fill == 0u { list[i] = found; }
}
