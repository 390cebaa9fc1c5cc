// The warm start of the next step: the sum of each pair's multipliers. No search starts from the normal of a pair
// without rows.

var<storage, read> row_start: array<u32>;
var<storage, read> gamma: array<real>;
var<storage, read_write> contacts: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    var sum = real(0.0);
    for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
        sum += gamma[row];
    }
    contacts[3u * p + 1u].w = sum;
    if row_start[p] == row_start[p + 1u] { contacts[3u * p].w = ONLY_DIRECTION; }
}
