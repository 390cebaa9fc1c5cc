// Copies the multipliers of each pair's branches from an old list of pairs to a new one.

var<storage, read> old_pair: array<u32>;
var<storage, read> old_remembered: array<real>;
var<storage, read_write> remembered: array<real>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    let old = old_pair[p];
    for (var k = 0u; k < BRANCHES; k += 1u) {
        remembered[BRANCHES * p + k] = 0.0;
        if old != NONE {
            remembered[BRANCHES * p + k] = old_remembered[BRANCHES * old + k];
        }
    }
}
