// Overdamped local drag: u = F / (xi L), w = 12 T / (xi L^3).
fn law(shape: vec4r, q: vec4r, load: Load, velocity: vec3r, kept: vec3r) -> Motion {
    let length = major_axis(shape);
    let translation = 1.0 / (DRAG * length);
    let rotation = 12.0 / (DRAG * length * length * length);
    return Motion(translation * load.force, rotation * load.torque, sqrt(translation), sqrt(rotation), mat3r(), vec3r());
}
