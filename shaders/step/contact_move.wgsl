// The displacement of a body's centre by contact from its free motion. `motions` is the kernel's array of motions,
// and `parameters` have the interval.
fn contact_move(body: u32) -> vec3r {
    let moved = parameters.dt * (motions[MOTION * body + 2u].xyz - motions[MOTION * body].xyz);
    // In the plane, the component of the free motion across it does not count.
    return select(moved, vec3r(moved.xy, 0.0), PLANAR);
}
