// Copies the two entries of every pair to their positions in the lists of its bodies.
var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> first: array<u32>;
var<storage, read> keys: array<u32>;
var<storage, read> entries: array<u32>;
var<storage, read> own: array<u32>;
var<storage, read_write> adjacency: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let k = invocation(group, groups, local);
    if k >= parameters.count { return; }
    let body = keys[k];
    let entry = entries[k];
    let later = entry / 2u >= first[body];
    adjacency[k + first[body + select(0u, 1u, later)]] = entry;
    let pair = pairs[k];
    let side = select(1u, 0u, first[pair.x] <= k && k < first[pair.x + 1u]);
    adjacency[k + own[pair[side]]] = 2u * k + side;
}
