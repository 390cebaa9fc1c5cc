// How far contact moves a body's centre from where its free motion leads. `motions` is the kernel's array of motions,
// and `parameters` have the interval.
fn contact_move(body: u32) -> vec3r {
    let moved = parameters.dt * (motions[MOTION * body + 2u].xyz - motions[MOTION * body].xyz);
    // In the plane what free motion has across it is no motion.
    return select(moved, vec3r(moved.xy, 0.0), PLANAR);
}
