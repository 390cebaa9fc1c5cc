// The number of rows of each body.

struct Parameters { bodies: u32, a: u32, b: u32, c: u32 }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> adjacency_start: array<u32>;
@group(0) @binding(2) var<storage, read> adjacency: array<u32>;
@group(0) @binding(3) var<storage, read> row_start: array<u32>;
@group(0) @binding(4) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    var count = 0u;
    for (var k = adjacency_start[i]; k < adjacency_start[i + 1u]; k += 1u) {
        let pair = adjacency[k] >> 1u;
        count += row_start[pair + 1u] - row_start[pair];
    }
    counts[i] = count;
}
