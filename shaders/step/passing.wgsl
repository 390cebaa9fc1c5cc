// Whether two bodies of a candidate pair may pass through each other in the step: if the relative motion of their
// surfaces suffices, and their centres come so near on the path that the bodies could overlap that deeply.
// src/step/passing.rs has the rule; the pairs that pass are among these.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> motions: array<vec4r>;
var<storage, read_write> report: Report;

// Sizes do not depend on the orientation of a body.
fn unturned(body: u32) -> Placed {
    return Placed(u32(shapes[body].w), shapes[body].xyz, vec4r(0.0, 0.0, 0.0, 1.0));
}

fn may_pass(a: u32, b: u32) -> bool {
    // The rounding error of a bound, relative to its terms.
    let roundings = 32.0 * EPSILON;
    let body_a = unturned(a);
    let body_b = unturned(b);
    let radius_a = bounding_radius(body_a);
    let radius_b = bounding_radius(body_b);
    let deep = DEEPER * min(thickness(body_a), thickness(body_b));
    let first_a = MOTION * a + 2u;
    let first_b = MOTION * b + 2u;
    let travel = parameters.dt * (motions[first_b].xyz - motions[first_a].xyz);
    let turned = parameters.dt
        * (radius_a * length(motions[first_a + 1u].xyz) + radius_b * length(motions[first_b + 1u].xyz));
    let square = dot(travel, travel);
    // If numbers overflow, nothing is known.
    if !is_finite(square) || !is_finite(turned) { return true; }
    if sqrt(square) + turned < 2.0 * deep * (1.0 - roundings) { return false; }
    let delta = lattice_difference(cells[a].xyz, remainders[a].xyz, cells[b].xyz, remainders[b].xyz);
    var nearest = delta;
    if square > 0.0 {
        nearest += clamp(-dot(delta, travel) / square, real(0.0), real(1.0)) * travel;
    }
    let reach = radius_a + radius_b - deep + roundings * (length(delta) + sqrt(square));
    return length(nearest) <= reach;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    if may_pass(pairs[p].x, pairs[p].y) && atomicLoad(&report.passing) == 0u {
        atomicMax(&report.passing, 1u);
    }
}
