// Removes the branches whose row was tightened from each pair's mask; the others get a row.

var<storage, read> next_start: array<u32>;
var<storage, read> staged: array<vec4r>;
var<storage, read> partners: array<u32>;
var<storage, read_write> contacts: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    var mask = u32(contacts[3u * p + 1u].w);
    if mask == 0u { return; }
    for (var place = next_start[p]; place < next_start[p + 1u]; place += 1u) {
        if partners[place] == NONE {
            mask &= ~(1u << (u32(staged[3u * place + 2u].w) - 1u));
        }
    }
    contacts[3u * p + 1u].w = real(mask);
}
