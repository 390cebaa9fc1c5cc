// Adds the sum of all earlier blocks to every entry.
var<storage, read> before: array<u32>;
var<storage, read_write> out: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.entries { return; }
    out[i] += before[i / (WORKGROUP * ITEMS)];
}
