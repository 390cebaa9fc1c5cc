// Points on a lattice: x = cell * PITCH + remainder, the remainder within half a pitch to each side. PITCH is a power
// of two, so multiplying by it is exact, and cells are integers, so differences are as exact far from the origin as
// near it.
struct LatticePoint { cell: vec3<i32>, remainder: vec3r }

// From a to b.
fn lattice_difference(cell_a: vec3<i32>, remainder_a: vec3r, cell_b: vec3<i32>, remainder_b: vec3r) -> vec3r {
    return vec3r(cell_b - cell_a) * PITCH + (remainder_b - remainder_a);
}

// The point moved by a step. Whole pitches go into the cell without loss; only the remainder is rounded, to less than
// EPSILON pitches, so that small steps add up.
fn lattice_add(cell: vec3<i32>, remainder: vec3r, step: vec3r) -> LatticePoint {
    let whole = round(step * INVERSE_PITCH);
    let sum = remainder + (step - whole * PITCH);
    let carry = round(sum * INVERSE_PITCH);
    return LatticePoint(cell + vec3<i32>(whole) + vec3<i32>(carry), sum - carry * PITCH);
}
