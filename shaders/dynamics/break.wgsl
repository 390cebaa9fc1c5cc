// A bond whose tension k (|way| - l) exceeds its strength breaks for good; one with a negative strength never
// breaks.

var<storage, read> strengths: array<real>;
var<storage, read_write> broken: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let bond = invocation(group, groups, local);
    if bond >= parameters.bonds { return; }
    // A bond that has lost a body has no ends.
    if strengths[bond] < 0.0 || ends[bond].x == NONE { return; }
    let tension = bonds[2u * bond].w * (length(way_of(bond)) - bonds[2u * bond + 1u].w);
    if tension > strengths[bond] { broken[bond] = 1u; }
}
