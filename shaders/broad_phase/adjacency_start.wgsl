// The offset of every body's list, and the difference between a pair's position in the list and its index, for pairs
// that the body found.
//
// The list of a body ascends: pairs that earlier bodies found, its own, pairs that later bodies found.
var<storage, read> first: array<u32>;
// Sorted by the body that was found, then by pair.
var<storage, read> keys: array<u32>;
var<storage, read> entries: array<u32>;
var<storage, read_write> adjacency_start: array<u32>;
var<storage, read_write> own: array<u32>;

// The first position whose body is `body` or later and, if it is `body`, whose entry is not below `entry`.
fn place(body: u32, entry: u32) -> u32 {
    var low = 0u;
    var high = parameters.pairs;
    while low < high {
        let middle = (low + high) / 2u;
        if keys[middle] < body || (keys[middle] == body && entries[middle] < entry) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i > parameters.bodies { return; }
    adjacency_start[i] = first[i] + place(i, 0u);
    if i < parameters.bodies { own[i] = place(i, 2u * first[i]); }
}
