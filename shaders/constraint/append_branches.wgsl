// Makes the rows of all staged contacts, each with the number of its branch and whether it is a first row.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> row_start: array<u32>;
var<storage, read> staged: array<vec4r>;
var<storage, read> motions: array<vec4r>;
var<storage, read_write> row_pairs: array<vec2<u32>>;
var<storage, read_write> jacobian: array<vec4r>;
var<storage, read_write> q: array<real>;
var<storage, read_write> features: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
        let made = u32(staged[3u * row + 2u].w);
        if made == 0u { continue; }
        let contact = over_corrected(staged[3u * row]);
        append(row, pairs[p], contact, staged[3u * row + 1u].xyz, staged[3u * row + 2u].xyz);
        features[row] = (made - 1u) | select(0u, FIRST_ROW, parameters.first > 0u);
    }
}
