// Standard deviations of the random force along any axis, and of the torques about the principal axes.
fn strength(shape: vec4r, dt: real) -> vec4r {
    let length = major_axis(shape);
    let resistance = DRAG * length;
    let turning = resistance * length * length / 12.0;
    return vec4r(sqrt(2.0 * TEMPERATURE * resistance / dt), vec3r(sqrt(2.0 * TEMPERATURE * turning / dt)));
}
