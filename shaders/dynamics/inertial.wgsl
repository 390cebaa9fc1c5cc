// Newton's and Euler's equations over one step: u + dt F / m, the mean angular velocity of a free rotation from L + dt
// T, effective mobility dt M^-1. In the step's middle only the impulses; `middle.wgsl` computes from them the motion of
// the step from its start.
fn law(shape: vec4r, q: vec4r, load: Load, velocity: vec3r, kept: vec3r) -> Motion {
    let body = solid(shape);
    let mass = DENSITY * body.volume;
    let moments = DENSITY * body.inertia;
    let root = sqrt(vec3r(parameters.dt) / moments);
    let x = rotate(q, vec3r(1.0, 0.0, 0.0));
    let y = rotate(q, vec3r(0.0, 1.0, 0.0));
    let z = rotate(q, vec3r(0.0, 0.0, 1.0));
    let matrix = mat3r(
        root.x * x.x * x + root.y * y.x * y + root.z * z.x * z,
        root.x * x.y * x + root.y * y.y * y + root.z * z.y * z,
        root.x * x.z * x + root.y * y.z * y + root.z * z.z * z,
    );
    let speeding = parameters.dt / mass * load.force;
    var impulse = parameters.dt / moments.x * load.torque;
    if PLANAR {
        impulse = parameters.dt * rotate(q, rotate_back(q, load.torque) / moments);
    }
    let translation = sqrt(parameters.dt / mass);
    if parameters.in_middle > 0u {
        return Motion(speeding, vec3r(), translation, 0.0, matrix, impulse);
    }
    let even = moments_of(shape);
    let momentum = momentum_kept(even, q, kept) + impulse;
    return Motion(velocity + speeding, turning_of(even, q, momentum, parameters.dt), translation, 0.0, matrix, momentum);
}
