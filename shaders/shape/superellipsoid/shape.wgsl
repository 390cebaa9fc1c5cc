// Volume, inertia, drag length and axis of any shape, with those of superellipsoids; the others' are in shape.wgsl.

fn solid(shape: vec4r) -> Solid {
    if !is_superellipsoid(u32(shape.w)) { return solid_of_others(shape); }
    let known = exponents_of(u32(shape.w));
    let box_part = shape.x * shape.y * shape.z;
    let moments = box_part * known.moments * shape.xyz * shape.xyz;
    return Solid(known.volume * box_part, moments.yzx + moments.zxy);
}

fn major_axis(shape: vec4r) -> real {
    if !is_superellipsoid(u32(shape.w)) { return major_axis_of_others(shape); }
    return 2.0 * radius_about(shape.xyz, exponents_of(u32(shape.w)).exponents);
}

fn axis_of_revolution(shape: vec4r) -> vec3r {
    if !is_superellipsoid(u32(shape.w)) { return axis_of_revolution_of_others(shape); }
    let exponents = exponents_of(u32(shape.w)).exponents;
    let is_ball = exponents.x == 2.0 && shape.x == shape.y && shape.y == shape.z;
    let is_round = exponents.y == 2.0 && shape.x == shape.y && !is_ball;
    return select(vec3r(), vec3r(0.0, 0.0, 1.0), is_round);
}
