// Newton's and Euler's equations with drag over one step, solved exactly for steady forces about the axes of the step's
// start. In the step's middle only the impulses of half a step; `damped_middle.wgsl` computes from them the motion of
// the step from its start.
fn law(shape: vec4r, q: vec4r, load: Load, velocity: vec3r, kept: vec3r) -> Motion {
    let body = solid(shape);
    let mass = DENSITY * body.volume;
    let moments = DENSITY * body.inertia;
    let time = select(parameters.dt, 0.5 * parameters.dt, parameters.in_middle > 0u);
    let whole = damping(shape, parameters.dt);
    let part = damping(shape, time);
    let root = sqrt(parameters.dt / moments * whole.turn_share);
    let x = rotate(q, vec3r(1.0, 0.0, 0.0));
    let y = rotate(q, vec3r(0.0, 1.0, 0.0));
    let z = rotate(q, vec3r(0.0, 0.0, 1.0));
    let matrix = mat3r(
        root.x * x.x * x + root.y * y.x * y + root.z * z.x * z,
        root.x * x.y * x + root.y * y.y * y + root.z * z.y * z,
        root.x * x.z * x + root.y * y.z * y + root.z * z.z * z,
    );
    let speeding = part.share * time / mass * load.force;
    var impulse = parts_of(q, part.turn_share, time / moments.x * load.torque);
    if PLANAR {
        impulse = parts_of(q, time * part.turn_share / moments, load.torque);
    }
    let translation = sqrt(parameters.dt / mass * whole.share);
    if parameters.in_middle > 0u {
        return Motion(speeding, vec3r(), translation, 0.0, matrix, impulse);
    }
    let even = moments_of(shape);
    let momentum = parts_of(q, part.turn_kept, momentum_kept(even, q, kept)) + impulse;
    let turning = turning_of(even, q, momentum, parameters.dt);
    return Motion(part.kept * velocity + speeding, turning, translation, 0.0, matrix, momentum);
}
