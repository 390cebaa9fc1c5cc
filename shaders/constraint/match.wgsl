// The first row of the same branch that each staged contact may tighten: one and its place, or zero.

var<storage, read> row_start: array<u32>;
// Where the rows will begin, with room for the staged contacts.
var<storage, read> next_start: array<u32>;
var<storage, read> features: array<u32>;
var<storage, read> staged: array<vec4r>;
var<storage, read_write> partners: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    for (var place = next_start[p]; place < next_start[p + 1u]; place += 1u) {
        partners[place] = 0u;
        let made = u32(staged[3u * place + 2u].w);
        if made == 0u { continue; }
        for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
            if features[row] == ((made - 1u) | FIRST_ROW) {
                partners[place] = row + 1u;
                break;
            }
        }
    }
}
