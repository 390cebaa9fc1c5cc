// Moves bodies into one cell of periodic space: along a periodic axis to lattice cells from 0 to PERIOD_CELLS + 1. Open
// axes keep their coordinates. Remainders grow to two and a half pitches at most.
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read_write> wrapped_cells: array<vec4<i32>>;
var<storage, read_write> wrapped_remainders: array<vec4r>;

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
        at = without_periods(at, vec3<i32>(floor(vec3r(at.cell) * PERIODS_A_CELL)));
        // The count may have an error of one.
        let below = select(vec3<i32>(0), vec3<i32>(1), at.cell < vec3<i32>(0));
        let above = select(vec3<i32>(0), vec3<i32>(1), at.cell > PERIOD_CELLS + 1);
        at = without_periods(at, select(vec3<i32>(0), above - below, PERIOD_CELLS > vec3<i32>(0)));
    }
    wrapped_cells[i] = vec4<i32>(at.cell, 0);
    wrapped_remainders[i] = vec4r(at.remainder, 0.0);
}
