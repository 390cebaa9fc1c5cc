// Changes the separations of staged contacts from the look ahead, so that their rows are exact where the last
// velocities lead at the end of the step: g(U_last) = Phi(C(U_last)). A change above MOST_AIMED is not curvature: then
// the offset stays.

var<storage, read> pairs: array<vec2<u32>>;
// The start of the step, with the velocities of the last one.
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> twists: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> row_start: array<u32>;
var<storage, read_write> staged: array<vec4r>;

fn body_at_end(i: u32) -> Placed {
    let start = Orientation(orientations[2u * i], orientations[2u * i + 1u]);
    let end = orientation_advance(start, 0.5 * parameters.dt * twists[2u * i + 1u].xyz);
    return placed(shapes[i], end.coarse, end.fine);
}

// The contribution of a body's rotation in the rest of the step to the separation, over dt: torque_arm in
// src/constraint.
fn turning(i: u32, normal: vec3r, lever: vec3r) -> real {
    let last = twists[2u * i + 1u].xyz;
    let there = cross(lever, normal);
    let half = 0.5 * AHEAD * parameters.dt * last;
    let arm = (there - cross(half, there)) / (1.0 + dot(half, half));
    return (1.0 - AHEAD) * dot(arm, last);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    let a = pairs[p].x;
    let b = pairs[p].y;
    if is_surface(b) { return; }
    let apart = lattice_difference(cells[a].xyz, remainders[a].xyz, cells[b].xyz, remainders[b].xyz);
    let slid = twists[2u * b].xyz - twists[2u * a].xyz;
    let delta = apart + parameters.dt * slid;
    let body_a = body_at_end(a);
    let body_b = body_at_end(b);
    if !are_rods(body_a, body_b) { return; }
    for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
        let k = u32(staged[3u * row + 2u].w);
        // None, or the separation itself.
        if k < 2u { continue; }
        let end = end_of(delta, body_a, body_b, k - 1u);
        let separation = length(end.gap) - (tube_radius(body_a) + tube_radius(body_b));
        let found = staged[3u * row];
        let turned = turning(b, found.xyz, staged[3u * row + 2u].xyz) - turning(a, found.xyz, staged[3u * row + 1u].xyz);
        let aimed = separation - parameters.dt * ((1.0 - AHEAD) * dot(found.xyz, slid) + turned);
        if abs(aimed - found.w) <= MOST_AIMED { staged[3u * row].w = aimed; }
    }
}
