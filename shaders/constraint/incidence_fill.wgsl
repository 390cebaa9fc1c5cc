// Each body's rows, ascending: 2 row + side.

var<storage, read> adjacency_start: array<u32>;
var<storage, read> adjacency: array<u32>;
var<storage, read> row_start: array<u32>;
var<storage, read> incidence_start: array<u32>;
var<storage, read_write> incidence: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    var next = incidence_start[i];
    for (var k = adjacency_start[i]; k < adjacency_start[i + 1u]; k += 1u) {
        let pair = adjacency[k] >> 1u;
        let side = adjacency[k] & 1u;
        for (var row = row_start[pair]; row < row_start[pair + 1u]; row += 1u) {
            incidence[next] = 2u * row + side;
            next += 1u;
        }
    }
}
