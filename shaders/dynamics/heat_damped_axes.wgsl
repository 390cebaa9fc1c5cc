// Standard deviations of the random force along the principal axes, and of the torques about them, for bodies with
// inertia and drag that depends on the direction.
fn lost_by_axis(a: vec3r) -> vec3r {
    return vec3r(lost(a.x), lost(a.y), lost(a.z));
}

fn spread(resistance: vec3r, rate: vec3r, dt: real) -> vec3r {
    let part = lost_by_axis(rate * dt);
    return sqrt(TEMPERATURE * resistance * rate * (2.0 - part) / part);
}

fn pushes(shape: vec4r, dt: real) -> vec3r {
    let resistance = resistance_of(shape).linear;
    return spread(resistance, resistance / (DENSITY * solid(shape).volume), dt);
}

fn strength(shape: vec4r, dt: real) -> vec4r {
    let resistance = resistance_of(shape).turning;
    return vec4r(0.0, spread(resistance, resistance / (DENSITY * solid(shape).inertia), dt));
}
