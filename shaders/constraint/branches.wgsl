// Chooses the branches of each pair that get a row. A first row goes to each branch that may become active in the step,
// and to each branch that ended the last step with a multiplier. At a trial a row goes to each branch that violates.
// The mask replaces the fourth number beside the lever of the first body.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
// The velocities of the last step.
var<storage, read> start_twists: array<vec4r>;
var<storage, read> remembered: array<real>;
var<storage, read_write> contacts: array<vec4r>;

fn body_at(i: u32) -> Placed {
    return placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]);
}

fn turning(i: u32, body: Placed) -> vec3r {
    return last_turning(shapes[i], body.orientation, start_twists[2u * i + 1u].xyz);
}

fn rows_of(p: u32) -> u32 {
    let a = pairs[p].x;
    let b = pairs[p].y;
    if !BRANCHED || is_surface(b) { return WHOLE; }
    let body_a = body_at(a);
    let body_b = body_at(b);
    if !has_branches(body_a, body_b) { return WHOLE; }
    let delta = lattice_difference(cells[a].xyz, remainders[a].xyz, cells[b].xyz, remainders[b].xyz);
    let contact = contacts[3u * p];
    if parameters.at_trial > 0u {
        let violating = -real(parameters.violating);
        return branches_within(delta, body_a, body_b, contact.w, violating, HUGE, 0u);
    }
    var pushed = 0u;
    for (var k = 0u; k < BRANCHES; k += 1u) {
        if remembered[BRANCHES * p + k] > 0.0 { pushed |= 1u << k; }
    }
    let turned = parameters.dt * (turning(b, body_b) - turning(a, body_a));
    let slid = parameters.dt * length(start_twists[2u * b].xyz - start_twists[2u * a].xyz);
    let slack = branch_slack(body_a, body_b, contact.xyz, turned, slid);
    return branches_within(delta, body_a, body_b, contact.w, contacts[3u * p + 1u].w, contact.w + slack, pushed);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    var mask = 0u;
    if contacts[3u * p + 2u].w >= select(NEAR, VIOLATING, parameters.at_trial > 0u) {
        mask = rows_of(p);
    }
    contacts[3u * p + 1u].w = real(mask);
}
