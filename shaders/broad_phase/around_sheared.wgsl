// As `around` of find_periodic.wgsl, in a sheared cell: images beyond the side across the gradient are displaced along
// the direction, so a search there covers all cells along it.
fn around_sheared(cell: vec3<i32>, span: vec3<i32>, level: u32) -> Around {
    var look = around(cell, span, level);
    let low = cell[SHEAR_GRADIENT] - span[SHEAR_GRADIENT];
    let high = cell[SHEAR_GRADIENT] + span[SHEAR_GRADIENT];
    if low < 0 || high >= PERIOD_CELLS[SHEAR_GRADIENT] {
        look.start[SHEAR_DIRECTION] = 0;
        look.count[SHEAR_DIRECTION] = grid_cell(PERIOD_CELLS + 1, level)[SHEAR_DIRECTION] + 1;
    }
    return look;
}
