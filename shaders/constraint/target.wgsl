// The new position of each row when pairs get more rows or other positions. The rows of a pair keep their order, at the
// front of its new range. A target is the position plus one; zero for rows whose pair has no new position.

var<storage, read> old_start: array<u32>;
var<storage, read> new_start: array<u32>;
var<storage, read> old_pair: array<u32>;
var<storage, read_write> targets: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    var old = p;
    if parameters.mapped != 0u {
        old = old_pair[p];
        if old == NONE { return; }
    }
    let first = old_start[old];
    for (var k = 0u; k < old_start[old + 1u] - first; k += 1u) {
        targets[first + k] = new_start[p] + k + 1u;
    }
}
