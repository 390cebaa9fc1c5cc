// Instructions on all rows; with PRODUCT, first the rows of a product.
@group(0) @binding(1) var<storage, read> program: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> scalars: array<real>;
@group(0) @binding(3) var<storage, read_write> vectors: array<real>;
@group(0) @binding(4) var<storage, read_write> partial: array<real>;

fn number(place: u32) -> real { return scalars[place]; }

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = invocation(group, groups, local);
    let step = parameters.groups * WORKGROUP;
    begin_rows(first, step);
    for (var place = parameters.begin; place < parameters.end; place += 2u) {
        let i = instruction(place);
        let kind = reduction_kind(i.what);
        var sum = identity(kind);
        for (var row = first; row < parameters.rows; row += step) {
            sum = join(kind, sum, run_row(i, row));
        }
        if i.what >= DOT {
            lanes[i.out * WORKGROUP + local] = sum;
        }
    }
    leave_sums(group_index(group, groups), local);
}
