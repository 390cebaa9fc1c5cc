// As wrap.wgsl, in a sheared cell: first across the gradient, then along the other axes.
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read_write> wrapped_cells: array<vec4<i32>>;
var<storage, read_write> wrapped_remainders: array<vec4r>;

// The number of periods by which a cell is below or above the target cell: at most one is counted.
fn beyond(cell: vec3<i32>) -> vec3<i32> {
    let below = select(vec3<i32>(0), vec3<i32>(1), cell < vec3<i32>(0));
    let above = select(vec3<i32>(0), vec3<i32>(1), cell > PERIOD_CELLS + 1);
    return select(vec3<i32>(0), above - below, PERIOD_CELLS > vec3<i32>(0));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    var at = LatticePoint(cells[i].xyz, remainders[i].xyz);
    // A body too far out keeps its position and is refused.
    if all(at.cell > vec3<i32>(-MOST_CELL)) && all(at.cell < vec3<i32>(MOST_CELL)) {
        let parts = vec3r(at.cell) * PERIODS_A_CELL;
        var many = vec3<i32>(floor(parts));
        many[SHEAR_DIRECTION] = i32(floor(periods_across(many[SHEAR_GRADIENT], parts[SHEAR_DIRECTION])));
        at = without_periods(at, many);
        // The counts may have an error of one, and one more period across the gradient displaces by up to half a
        // period.
        var one = vec3<i32>(0);
        one[SHEAR_GRADIENT] = beyond(at.cell)[SHEAR_GRADIENT];
        at = without_periods(at, one);
        for (var k = 0; k < 2; k += 1) {
            one = beyond(at.cell);
            one[SHEAR_GRADIENT] = 0;
            at = without_periods(at, one);
        }
    }
    wrapped_cells[i] = vec4<i32>(at.cell, 0);
    wrapped_remainders[i] = vec4r(at.remainder, 0.0);
}
