// A stage on all rows: what it does is generated.
@group(0) @binding(1) var<storage, read> scalars: array<real>;
@group(0) @binding(2) var<storage, read_write> vectors: array<real>;
@group(0) @binding(3) var<storage, read_write> partial: array<real>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    rows_before(invocation(group, groups, local), parameters.groups * WORKGROUP, local);
    leave_sums(group_index(group, groups), local);
}
