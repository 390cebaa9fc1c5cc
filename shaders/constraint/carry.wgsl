// Copies the memory of each pair, and its number of rows, from an old list of pairs to a new one.

var<storage, read> old_pair: array<u32>;
var<storage, read> old_contacts: array<vec4r>;
var<storage, read> old_row_start: array<u32>;
var<storage, read_write> contacts: array<vec4r>;
var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    let old = old_pair[p];
    counts[p] = 0u;
    for (var k = 0u; k < 3u; k += 1u) {
        contacts[3u * p + k] = vec4r();
    }
    if old == NONE { return; }
    for (var k = 0u; k < 3u; k += 1u) {
        contacts[3u * p + k] = old_contacts[3u * old + k];
    }
    if parameters.has_rows != 0u {
        counts[p] = old_row_start[old + 1u] - old_row_start[old];
    }
}
