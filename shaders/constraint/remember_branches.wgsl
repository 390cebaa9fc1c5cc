// The warm start of the next part of a step: the sums of each pair's multipliers, branch by branch. After an accepted
// step, no search starts from the normal of a pair without rows.

var<storage, read> row_start: array<u32>;
var<storage, read> gamma: array<real>;
var<storage, read> features: array<u32>;
var<storage, read_write> remembered: array<real>;
var<storage, read_write> contacts: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    if parameters.accepted > 0u && row_start[p] == row_start[p + 1u] { contacts[3u * p].w = ONLY_DIRECTION; }
    for (var k = 0u; k < BRANCHES; k += 1u) {
        var sum = real(0.0);
        for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
            if (features[row] & ~FIRST_ROW) == k { sum += gamma[row]; }
        }
        remembered[BRANCHES * p + k] = sum;
    }
}
