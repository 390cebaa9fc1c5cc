// From a to the nearest image of b in a sheared cell: the nearest across the gradient, and of its images along the
// direction the nearest. At half a period, up to rounding, the result is either of two images.
fn lattice_difference(cell_a: vec3<i32>, remainder_a: vec3r, cell_b: vec3<i32>, remainder_b: vec3r) -> vec3r {
    var to = LatticePoint(cell_b - cell_a, remainder_b - remainder_a);
    let parts = vec3r(to.cell) * PERIODS_A_CELL;
    var many = vec3<i32>(nearest_integer(parts));
    let along = periods_across(many[SHEAR_GRADIENT], parts[SHEAR_DIRECTION]);
    many[SHEAR_DIRECTION] = vec3<i32>(nearest_integer(vec3r(along))).x;
    if any(many != vec3<i32>(0)) { to = without_periods(to, many); }
    // The first count may have an error of one, across the gradient and then along the direction.
    var one = vec3<i32>(0);
    let across = nearest_integer((vec3r(to.cell) * PITCH + to.remainder) * INVERSE_PERIOD);
    one[SHEAR_GRADIENT] = vec3<i32>(across)[SHEAR_GRADIENT];
    if any(one != vec3<i32>(0)) { to = without_periods(to, one); }
    one = vec3<i32>(nearest_integer((vec3r(to.cell) * PITCH + to.remainder) * INVERSE_PERIOD));
    one[SHEAR_GRADIENT] = 0;
    if any(one != vec3<i32>(0)) { to = without_periods(to, one); }
    return vec3r(to.cell) * PITCH + to.remainder;
}
