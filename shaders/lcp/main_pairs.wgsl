// Instructions on the rows of all pairs, with the small problems of the pairs in the middle. A pair's rows are one invocation's.
@group(0) @binding(1) var<storage, read> program: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> scalars: array<real>;
@group(0) @binding(3) var<storage, read_write> vectors: array<real>;
@group(0) @binding(4) var<storage, read_write> partial: array<real>;
@group(0) @binding(5) var<storage, read> block_start: array<u32>;
@group(0) @binding(6) var<storage, read> pair: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read> jacobian: array<vec4r>;

fn number(place: u32) -> real { return scalars[place]; }
fn pair_of(row: u32) -> vec2<u32> { return pair[row]; }

fn run_instructions(begin: u32, end: u32, first: u32, step: u32, local: u32) {
    for (var place = begin; place < end; place += 2u) {
        let i = instruction(place);
        let kind = reduction_kind(i.what);
        var sum = identity(kind);
        for (var slot = first; slot < parameters.pairs; slot += step) {
            let last = block_start[slot + 1u];
            for (var row = block_start[slot]; row < last; row += 1u) {
                sum = join(kind, sum, run_row(i, row));
            }
        }
        if i.what >= DOT {
            lanes[i.out * WORKGROUP + local] = sum;
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = invocation(group, groups, local);
    let step = parameters.groups * WORKGROUP;
    run_instructions(parameters.begin, parameters.middle, first, step, local);
    let i = instruction(parameters.middle);
    for (var slot = first; slot < parameters.pairs; slot += step) {
        minimize_block(block_start[slot], block_start[slot + 1u], i.a, i.b, i.s, i.out);
    }
    run_instructions(parameters.middle + 2u, parameters.end, first, step, local);
    leave_sums(group_index(group, groups), local);
}
