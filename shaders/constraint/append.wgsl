// Makes the last row of every pair whose flag is at least the threshold.

struct Parameters { pairs: u32, threshold: u32, warm: u32, bodies: u32, dt: real, root_dt: real }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> row_start: array<u32>;
@group(0) @binding(3) var<storage, read> contacts: array<vec4r>;
@group(0) @binding(4) var<storage, read> motions: array<vec4r>;
@group(0) @binding(5) var<storage, read_write> row_pairs: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> jacobian: array<vec4r>;
@group(0) @binding(7) var<storage, read_write> q: array<real>;
@group(0) @binding(8) var<storage, read_write> gamma: array<real>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs || u32(contacts[3u * p + 2u].w) < parameters.threshold { return; }
    let row = row_start[p + 1u] - 1u;
    let contact = contacts[3u * p];
    append(row, pairs[p], contact, contacts[3u * p + 1u].xyz, contacts[3u * p + 2u].xyz);
    gamma[row] = select(real(0.0), contacts[3u * p + 1u].w, parameters.warm != 0u);
}
