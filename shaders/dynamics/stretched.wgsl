// The displacement of a body's surface along its outward normal at the contact point `lever`.
fn stretch(body: u32, lever: vec3r, normal: vec3r) -> real {
    let shape = shapes[body];
    if !grows(shape) { return 0.0; }
    let axis = rotate(unit_quaternion(orientations[2u * body], orientations[2u * body + 1u]), vec3r(0.0, 0.0, 1.0));
    let half = 0.5 * (shape.y - shape.x);
    let along = dot(axis, normal);
    // Between its middle and a tip a point of the axis moves in proportion to its coordinate. The axis of a cell as
    // long as thick is its middle: it grows towards the contact.
    var share = select(real(-1.0), real(1.0), along >= 0.0);
    if half > 0.0 {
        share = clamp(dot(axis, lever - 0.5 * shape.x * normal) / half, real(-1.0), real(1.0));
    }
    return 0.5 * (grown_shapes[body].y - shape.y) * share * along;
}
