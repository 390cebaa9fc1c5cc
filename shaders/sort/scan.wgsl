// The sum before every entry within its block, and the total of every block. Entries from `counted` on count as zero.
var<storage, read> counts: array<u32>;
var<storage, read_write> out: array<u32>;
var<storage, read_write> totals: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = group_index(group, groups);
    let first = (block * WORKGROUP + local) * ITEMS;
    var own = 0u;
    for (var i = first; i < min(first + ITEMS, parameters.counted); i += 1u) { own += counts[i]; }
    var sum = sum_before(own, local);
    if local == WORKGROUP - 1u && block < parameters.blocks { totals[block] = sum + own; }
    for (var i = first; i < min(first + ITEMS, parameters.entries); i += 1u) {
        out[i] = sum;
        if i < parameters.counted { sum += counts[i]; }
    }
}
