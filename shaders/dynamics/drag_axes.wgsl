// The resistances of a body with other drag along its axis than across it (src/dynamics/drag has the equations).
fn resistance_of(shape: vec4r) -> Resistance {
    let length = major_axis(shape);
    var linear = vec3r(PERPENDICULAR, PERPENDICULAR, PARALLEL);
    if u32(shape.w) == SPHERE {
        linear = vec3r((PARALLEL + 2.0 * PERPENDICULAR) / 3.0);
    }
    return Resistance(length * linear, vec3r(ROTATION * length * length * length / 12.0));
}
