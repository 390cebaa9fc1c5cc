// The part of a row for one of its bodies. `motions` is the kernel's array of motions, and `parameters` have the
// interval.

struct Part { linear: vec3r, angular: vec3r, still_to_come: real }

// One body's block and its share of dt D . (U_free - U_j), for the unit vector along which its surface is pushed.
fn part(body: u32, normal: vec3r, lever: vec3r) -> Part {
    let first = MOTION * body;
    let free = motions[first];
    let reached = motions[first + 2u].xyz;
    let turning = motions[first + 3u].xyz;
    let arm_there = cross(lever, normal);
    let half = 0.5 * parameters.dt * turning;
    var arm = (arm_there - cross(half, arm_there)) / (1.0 + dot(half, half));
    if !PLANAR && any(turning != vec3r()) {
        // The arm of a body of revolution may have a component along its axis where forces act, which would spin it.
        let axis = axis_of(body);
        arm -= dot(axis, arm) * axis;
    }
    let still = dot(normal, free.xyz - reached) + dot(arm, motions[first + 1u].xyz - turning);
    return Part(
        parameters.root_dt * free.w * normal,
        parameters.root_dt * rotation_root(body, arm),
        parameters.dt * still,
    );
}
