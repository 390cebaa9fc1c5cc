// A body with its pose, from the arrays of the state.
fn placed(shape: vec4r, coarse: vec4r, fine: vec4r) -> Placed {
    return Placed(u32(shape.w), shape.xyz, unit_quaternion(coarse, fine));
}
