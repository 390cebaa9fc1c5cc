// The start of every first body's pairs, and the end of the last one's.
// The first bodies of the pairs, ascending.
var<storage, read> keys: array<u32>;
var<storage, read_write> first: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i > parameters.bodies { return; }
    var low = 0u;
    var high = parameters.pairs;
    while low < high {
        let middle = (low + high) / 2u;
        if keys[middle] < i { low = middle + 1u; } else { high = middle; }
    }
    first[i] = low;
}
