// Overdamped drag that depends on the direction.
fn translation_roots(shape: vec4r) -> vec3r {
    return 1.0 / sqrt(resistance_of(shape).linear);
}

fn law(shape: vec4r, q: vec4r, load: Load, velocity: vec3r, kept: vec3r) -> Motion {
    let resists = resistance_of(shape);
    let mobility = 1.0 / resists.turning;
    return Motion(
        along_axes(q, 1.0 / resists.linear, load.force),
        along_axes(q, mobility, load.torque),
        0.0,
        0.0,
        axes_matrix(q, sqrt(mobility)),
        vec3r(),
    );
}
