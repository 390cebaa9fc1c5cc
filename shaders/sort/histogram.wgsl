// The number of keys with each digit in every block, sorted by digit. The atomics only count, so their order does not
// matter.
var<storage, read> keys: array<u32>;
var<storage, read_write> counts: array<u32>;

var<workgroup> count: array<atomic<u32>, DIGITS>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = group_index(group, groups);
    if local < DIGITS { atomicStore(&count[local], 0u); }
    workgroupBarrier();
    let first = block * WORKGROUP * ITEMS + local;
    for (var k = 0u; k < ITEMS; k += 1u) {
        let i = first + k * WORKGROUP;
        if i < parameters.n { atomicAdd(&count[(keys[i] >> parameters.shift) & parameters.mask], 1u); }
    }
    workgroupBarrier();
    if local < DIGITS && block < parameters.blocks { counts[local * parameters.blocks + block] = atomicLoad(&count[local]); }
}
