// The displacement of a body's surface along its outward normal at the contact point `lever`, where ellipsoids grow
// too.
fn stretch(body: u32, lever: vec3r, normal: vec3r) -> real {
    let shape = shapes[body];
    let q = unit_quaternion(orientations[2u * body], orientations[2u * body + 1u]);
    if u32(shape.w) == ELLIPSOID {
        // A point moves along each axis in proportion to its coordinate.
        let growth = grown_shapes[body].xyz / shape.xyz - 1.0;
        return dot(growth * rotate_back(q, lever), rotate_back(q, normal));
    }
    if u32(shape.w) != SPHEROCYLINDER { return 0.0; }
    let axis = rotate(q, vec3r(0.0, 0.0, 1.0));
    let half = 0.5 * (shape.y - shape.x);
    let along = dot(axis, normal);
    // As in stretched.wgsl.
    var share = select(real(-1.0), real(1.0), along >= 0.0);
    if half > 0.0 {
        share = clamp(dot(axis, lever - 0.5 * shape.x * normal) / half, real(-1.0), real(1.0));
    }
    return 0.5 * (grown_shapes[body].y - shape.y) * share * along;
}
