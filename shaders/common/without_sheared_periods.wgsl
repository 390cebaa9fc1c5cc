// Points on the lattice of a sheared periodic space. It replaces nearest_image.wgsl. The offset of images across the
// gradient is the fourth number of the parameters that hold the periods: whole pitches, rounded down, and four parts.
struct LatticePoint { cell: vec3<i32>, remainder: vec3r }

// As in nearest_image.wgsl: the point moved back by n periods; those across the gradient include the offset. Integers
// may overflow in between: the result for a small difference is still correct.
fn without_periods(at: LatticePoint, n: vec3<i32>) -> LatticePoint {
    let bits = vec3<u32>(11u);
    let mask = vec3<i32>(2047);
    var tilted = vec3<i32>(0);
    tilted[SHEAR_DIRECTION] = n[SHEAR_GRADIENT];
    let part_4 = n * PERIOD_PART_4 + tilted * parameters.periods[4].w;
    let part_3 = n * PERIOD_PART_3 + tilted * parameters.periods[3].w + (part_4 >> bits);
    let part_2 = n * PERIOD_PART_2 + tilted * parameters.periods[2].w + (part_3 >> bits);
    let part_1 = n * PERIOD_PART_1 + tilted * parameters.periods[1].w + (part_2 >> bits);
    let cells = n * PERIOD_CELLS + tilted * parameters.periods[0].w + (part_1 >> bits);
    let upper = vec3r(((part_1 & mask) << bits) | (part_2 & mask)) * UPPER_PARTS;
    let lower = vec3r(((part_3 & mask) << bits) | (part_4 & mask)) * LOWER_PARTS;
    return LatticePoint(at.cell - cells, at.remainder - upper - lower);
}

// The whole periods in these coordinates, by rounding or rounding down; along the direction the displacement by those
// across the gradient is subtracted first.
fn periods_across(across: i32, along: real) -> real {
    return along - real(across) * tilt_periods();
}
