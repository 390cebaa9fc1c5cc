// Appends the places of a body at surfaces to the pairs in its list.

var<storage, read> pair_start: array<u32>;
var<storage, read> pair_list: array<u32>;
var<storage, read> place_start: array<u32>;
var<storage, read_write> adjacency_start: array<u32>;
var<storage, read_write> adjacency: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i > parameters.bodies { return; }
    var to = pair_start[i] + place_start[i];
    adjacency_start[i] = to;
    if i == parameters.bodies { return; }
    for (var k = pair_start[i]; k < pair_start[i + 1u]; k += 1u) {
        adjacency[to] = pair_list[k];
        to += 1u;
    }
    for (var k = place_start[i]; k < place_start[i + 1u]; k += 1u) {
        adjacency[to] = 2u * (parameters.first + k);
        to += 1u;
    }
}
