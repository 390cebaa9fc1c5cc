// Standard deviations of the random force along the principal axes, and of the torques about them.
fn pushes(shape: vec4r, dt: real) -> vec3r {
    return sqrt(2.0 * TEMPERATURE / dt * resistance_of(shape).linear);
}

fn strength(shape: vec4r, dt: real) -> vec4r {
    return vec4r(0.0, sqrt(2.0 * TEMPERATURE / dt * resistance_of(shape).turning));
}
