// A stage on the rows of all pairs, with the small problems of the pairs in the middle. A pair's rows are one invocation's. What it
// does is generated.
@group(0) @binding(1) var<storage, read> scalars: array<real>;
@group(0) @binding(2) var<storage, read_write> vectors: array<real>;
@group(0) @binding(3) var<storage, read_write> partial: array<real>;
@group(0) @binding(4) var<storage, read> block_start: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = invocation(group, groups, local);
    let step = parameters.groups * WORKGROUP;
    rows_before(first, step, local);
    for (var slot = first; slot < parameters.pairs; slot += step) {
        run_block(block_start[slot], block_start[slot + 1u]);
    }
    rows_after(first, step, local);
    leave_sums(group_index(group, groups), local);
}
