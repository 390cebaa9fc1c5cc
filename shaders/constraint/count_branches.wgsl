// How many rows each pair will have: those it has, and one more for each branch in its mask.

var<storage, read> contacts: array<vec4r>;
var<storage, read> row_start: array<u32>;
var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    var count = countOneBits(u32(contacts[3u * p + 1u].w));
    if parameters.has_rows != 0u {
        count += row_start[p + 1u] - row_start[p];
    }
    counts[p] = count;
}
