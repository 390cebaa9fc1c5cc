// The index of an invocation in a grid of workgroups folded into two dimensions.
fn invocation(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * WORKGROUP + local;
}

fn group_index(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

// Whether a number is finite, from its bits: compilers may change comparisons with NaN.
fn is_finite(x: real) -> bool {
    return (bitcast<u32>(f32(x)) & 0x7f800000u) != 0x7f800000u;
}

// The result for an invalid code, which the host recognizes as an error.
fn not_a_number() -> real {
    var zero = real(0.0);
    return zero / zero;
}
