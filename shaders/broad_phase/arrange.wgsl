// Copies pairs to their positions in the sorted order.
var<storage, read> found: array<vec2<u32>>;
var<storage, read> places: array<u32>;
var<storage, read_write> pairs: array<vec2<u32>>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let k = invocation(group, groups, local);
    if k >= parameters.count { return; }
    pairs[k] = found[places[k]];
}
