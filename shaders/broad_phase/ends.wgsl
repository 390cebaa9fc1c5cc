// The sort key of pairs: one of their bodies. Sorted by the second body, then by the first, the order of pairs depends
// only on the set of pairs.
struct Parameters { pairs: u32, side: u32, unused_1: u32, unused_2: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec2<u32>>;
// The index at which every pair was found. The second body is the first key, so there is no order yet.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let k = invocation(group, groups, local);
    if k >= parameters.pairs { return; }
    var place = k;
    if parameters.side == 0u { place = places[k]; }
    places[k] = place;
    keys[k] = pairs[place][parameters.side];
}
