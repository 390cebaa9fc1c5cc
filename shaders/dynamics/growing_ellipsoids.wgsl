// The functions of growth where ellipsoids grow too; their radii follow from their lengths in reshape.wgsl.
fn grows(shape: vec4r) -> bool {
    return u32(shape.w) == SPHEROCYLINDER || u32(shape.w) == ELLIPSOID;
}

fn with_length(shape: vec4r, length: real) -> vec4r {
    if u32(shape.w) == ELLIPSOID { return shape; }
    return vec4r(shape.x, length, shape.zw);
}

// The vector from the centre to the centre of the upper daughter of half the length, in body axes.
fn daughter_offset(length: real) -> vec3r {
    return vec3r(0.0, 0.0, 0.25 * length);
}
