// Starts the first rows of the whole step, one for each near pair, from the last multipliers of the first half's rows,
// and marks them.

var<storage, read> old_start: array<u32>;
var<storage, read> old_gamma: array<real>;
var<storage, read> row_start: array<u32>;
var<storage, read_write> gamma: array<real>;
var<storage, read_write> is_first: array<real>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs || row_start[p] == row_start[p + 1u] { return; }
    var sum = real(0.0);
    for (var row = old_start[p]; row < old_start[p + 1u]; row += 1u) {
        sum += old_gamma[row];
    }
    gamma[row_start[p]] = sum;
    is_first[row_start[p]] = 1.0;
}
