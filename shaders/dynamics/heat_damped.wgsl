// Standard deviations of the random force along any axis, and of the torques about the principal axes, for bodies with
// inertia and drag.
fn spread(resistance: real, rate: real, dt: real) -> real {
    let part = lost(rate * dt);
    return sqrt(TEMPERATURE * resistance * rate * (2.0 - part) / part);
}

fn strength(shape: vec4r, dt: real) -> vec4r {
    let body = solid(shape);
    let length = major_axis(shape);
    let resistance = DRAG * length;
    let turning = resistance * length * length / 12.0;
    let rates = turning / (DENSITY * body.inertia);
    return vec4r(
        spread(resistance, resistance / (DENSITY * body.volume), dt),
        spread(turning, rates.x, dt),
        spread(turning, rates.y, dt),
        spread(turning, rates.z, dt),
    );
}
