// Moves the rows of one array to their targets; a row without a target is dropped. Element is the array's type, PER_ROW
// the number of elements of a row.

var<storage, read> targets: array<u32>;
var<storage, read> source: array<Element>;
var<storage, read_write> moved: array<Element>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = invocation(group, groups, local);
    if row >= parameters.rows { return; }
    if targets[row] == 0u { return; }
    let target_row = targets[row] - 1u;
    for (var k = 0u; k < PER_ROW; k += 1u) {
        moved[PER_ROW * target_row + k] = source[PER_ROW * row + k];
    }
}
