// For every pair, the body that was found in it, and the pair's entry in that body's list.
var<storage, read> pairs: array<vec2<u32>>;
// The offset of the pairs that a body found.
var<storage, read> first: array<u32>;
var<storage, read_write> keys: array<u32>;
var<storage, read_write> entries: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let k = invocation(group, groups, local);
    if k >= parameters.count { return; }
    let pair = pairs[k];
    let side = select(0u, 1u, first[pair.x] <= k && k < first[pair.x + 1u]);
    keys[k] = pair[side];
    entries[k] = 2u * k + side;
}
