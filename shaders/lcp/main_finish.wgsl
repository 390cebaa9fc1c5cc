// One workgroup brings the partial sums of all together, runs the operations on numbers, and lets the rest of the batch
// do nothing after the last iteration.
@group(0) @binding(1) var<storage, read> program: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> scalars: array<real>;
@group(0) @binding(3) var<storage, read> partial: array<real>;
@group(0) @binding(4) var<storage, read_write> grid: array<u32>;

var<workgroup> totals: array<real, REDUCTIONS>;

fn taken(reduction: u32) -> real { return totals[reduction]; }

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) local: u32) {
    for (var place = local; place < NUMBERS; place += WORKGROUP) {
        numbers[place] = scalars[place];
    }
    if local == 0u {
        halted = select(0u, 1u, scalars[HALT] != 0.0);
    }
    if workgroupUniformLoad(&halted) != 0u { return; }
    let reduction = local / LANES;
    let kind = kind_of(parameters.kinds, reduction);
    var sum = identity(kind);
    if reduction < parameters.reductions {
        for (var group = local % LANES; group < parameters.groups; group += LANES) {
            sum = join(kind, sum, partial[reduction * parameters.groups + group]);
        }
    }
    sums[local] = sum;
    workgroupBarrier();
    if local < REDUCTIONS {
        totals[local] = total(local, parameters.kinds);
    }
    workgroupBarrier();
    if local == 0u {
        run_numbers(parameters.first, parameters.last);
    }
    workgroupBarrier();
    for (var place = local; place < NUMBERS; place += WORKGROUP) {
        scalars[place] = numbers[place];
    }
    if local < GRID_WORDS && halted != 0u {
        grid[local] = 0u;
    }
}
