// Points on the lattice of periodic space. Kernels that compare two bodies include this file instead of lattice.wgsl:
// their differences are to the nearest image.
//
// A period is PERIOD_CELLS pitches and four parts of 11 bits, each 2^-11 of the one before, all zero for an open axis.
struct LatticePoint { cell: vec3<i32>, remainder: vec3r }

// The point moved back by n periods, at most 2^20 of them. The carry of n times a part over 2^11 goes to the next
// coarser part, so the periods are exact; each of two differences of the remainder is rounded. The remainder grows by
// up to a pitch.
fn without_periods(at: LatticePoint, n: vec3<i32>) -> LatticePoint {
    let bits = vec3<u32>(11u);
    let mask = vec3<i32>(2047);
    let part_4 = n * PERIOD_PART_4;
    let part_3 = n * PERIOD_PART_3 + (part_4 >> bits);
    let part_2 = n * PERIOD_PART_2 + (part_3 >> bits);
    let part_1 = n * PERIOD_PART_1 + (part_2 >> bits);
    let cells = n * PERIOD_CELLS + (part_1 >> bits);
    // Two parts have 22 bits, which fit a float.
    let upper = vec3r(((part_1 & mask) << bits) | (part_2 & mask)) * UPPER_PARTS;
    let lower = vec3r(((part_3 & mask) << bits) | (part_4 & mask)) * LOWER_PARTS;
    return LatticePoint(at.cell - cells, at.remainder - upper - lower);
}

// From a to the nearest image of b. At half a period, up to rounding, the result is either of two images.
fn lattice_difference(cell_a: vec3<i32>, remainder_a: vec3r, cell_b: vec3<i32>, remainder_b: vec3r) -> vec3r {
    var to = LatticePoint(cell_b - cell_a, remainder_b - remainder_a);
    // Over many periods this count may have an error of one, which the second count corrects.
    let many = vec3<i32>(nearest_integer(vec3r(to.cell) * PERIODS_A_CELL));
    if any(many != vec3<i32>(0)) { to = without_periods(to, many); }
    let one = vec3<i32>(nearest_integer((vec3r(to.cell) * PITCH + to.remainder) * INVERSE_PERIOD));
    if any(one != vec3<i32>(0)) { to = without_periods(to, one); }
    return vec3r(to.cell) * PITCH + to.remainder;
}
