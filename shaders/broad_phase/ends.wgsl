// The sort key of pairs: one of their bodies. Pairs are sorted by the second body, then by the first; the resulting
// order depends only on the set of pairs.
var<storage, read> found: array<vec2<u32>>;
// The index of every pair in the list as found. The second body is the first key, so there is no earlier order.
var<storage, read_write> places: array<u32>;
var<storage, read_write> keys: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let k = invocation(group, groups, local);
    if k >= parameters.count { return; }
    var place = k;
    if parameters.side == 0u { place = places[k]; }
    places[k] = place;
    keys[k] = found[place][parameters.side];
}
