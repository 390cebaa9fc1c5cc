// Points on the lattice of periodic space. Kernels that compare two bodies include this file instead of lattice.wgsl:
// their differences lead to the nearest image.
//
// A period is PERIOD_CELLS pitches and four parts of 11 bits, each 2^-11 of the one before, all zero where an axis has
// none.
struct LatticePoint { cell: vec3<i32>, remainder: vec3r }

// The point moved back by n periods, at most 2^20 of them. What n times a part is over 2^11 goes into the next coarser
// one, so that the periods are exact; of the remainder each of two differences is rounded. It is longer by up to a
// pitch.
fn without_periods(at: LatticePoint, n: vec3<i32>) -> LatticePoint {
    let bits = vec3<u32>(11u);
    let mask = vec3<i32>(2047);
    let part_4 = n * PERIOD_PART_4;
    let part_3 = n * PERIOD_PART_3 + (part_4 >> bits);
    let part_2 = n * PERIOD_PART_2 + (part_3 >> bits);
    let part_1 = n * PERIOD_PART_1 + (part_2 >> bits);
    let cells = n * PERIOD_CELLS + (part_1 >> bits);
    // Two parts are 22 bits, which a float holds.
    let upper = vec3r(((part_1 & mask) << bits) | (part_2 & mask)) * UPPER_PARTS;
    let lower = vec3r(((part_3 & mask) << bits) | (part_4 & mask)) * LOWER_PARTS;
    return LatticePoint(at.cell - cells, at.remainder - upper - lower);
}

// From a to the nearest image of b. At half a period, to rounding, either of two may be taken.
fn lattice_difference(cell_a: vec3<i32>, remainder_a: vec3r, cell_b: vec3<i32>, remainder_b: vec3r) -> vec3r {
    var to = LatticePoint(cell_b - cell_a, remainder_b - remainder_a);
    // Over many periods this count may be one too many or too few, which the second one mends.
    let many = vec3<i32>(nearest_integer(vec3r(to.cell) * PERIODS_A_CELL));
    if any(many != vec3<i32>(0)) { to = without_periods(to, many); }
    let one = vec3<i32>(nearest_integer((vec3r(to.cell) * PITCH + to.remainder) * INVERSE_PERIOD));
    if any(one != vec3<i32>(0)) { to = without_periods(to, one); }
    return vec3r(to.cell) * PITCH + to.remainder;
}
