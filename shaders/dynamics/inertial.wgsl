// Newton's and Euler's equations over one step: U + dt M^-1 (F - gyroscopic), effective mobility dt M^-1.
fn law(shape: vec4r, q: vec4r, load: Load, velocity: vec3r, angular_velocity: vec3r) -> Motion {
    let body = solid(shape);
    let mass = DENSITY * body.volume;
    let moments = DENSITY * body.inertia;
    let turning = rotate_back(q, angular_velocity);
    let torque = rotate_back(q, load.torque) - cross(turning, moments * turning);
    let acceleration = rotate(q, torque / moments);
    let root = sqrt(vec3r(parameters.dt) / moments);
    let x = rotate(q, vec3r(1.0, 0.0, 0.0));
    let y = rotate(q, vec3r(0.0, 1.0, 0.0));
    let z = rotate(q, vec3r(0.0, 0.0, 1.0));
    let matrix = mat3r(
        root.x * x.x * x + root.y * y.x * y + root.z * z.x * z,
        root.x * x.y * x + root.y * y.y * y + root.z * z.y * z,
        root.x * x.z * x + root.y * y.z * y + root.z * z.z * z,
    );
    return Motion(velocity + parameters.dt / mass * load.force, angular_velocity + parameters.dt * acceleration, sqrt(parameters.dt / mass), 0.0, matrix);
}
