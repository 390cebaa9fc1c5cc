// The key that pairs are sorted by: one of their bodies. Sorted by the second body, then by the first, pairs stand in
// an order that depends on nothing but which pairs there are.
struct Parameters { count: u32, side: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec2<u32>>;
// Where every pair was found. The second body is the first key, so there is no order yet.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys: array<u32>;

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
    keys[k] = pairs[place][parameters.side];
}
