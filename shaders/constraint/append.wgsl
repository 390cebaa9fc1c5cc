// Makes the last row of every pair whose flag is at least the threshold.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> row_start: array<u32>;
var<storage, read> contacts: array<vec4r>;
var<storage, read> motions: array<vec4r>;
var<storage, read_write> row_pairs: array<vec2<u32>>;
var<storage, read_write> jacobian: array<vec4r>;
var<storage, read_write> q: array<real>;
var<storage, read_write> gamma: array<real>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs || u32(contacts[3u * p + 2u].w) < parameters.threshold { return; }
    let row = row_start[p + 1u] - 1u;
    let contact = over_corrected(contacts[3u * p]);
    append(row, pairs[p], contact, contacts[3u * p + 1u].xyz, contacts[3u * p + 2u].xyz);
    gamma[row] = select(real(0.0), contacts[3u * p + 1u].w, parameters.warm != 0u);
}
