// Reduces the partial sums of the previous stage: all workgroups in the same order.

// Invocations that share one sum.
const TAKERS: u32 = 32u;

var<workgroup> totals: array<real, REDUCTIONS>;

fn take_sums(local: u32, count: u32, kinds: u32) {
    for (var nth = local; nth < count * TAKERS; nth += WORKGROUP) {
        let kind = kind_of(kinds, nth / TAKERS);
        let begin = parameters.sums_from + nth / TAKERS * parameters.groups;
        var sum = identity(kind);
        for (var group = nth % TAKERS; group < parameters.groups; group += TAKERS) {
            sum = join(kind, sum, partial[begin + group]);
        }
        lanes[nth] = sum;
    }
    workgroupBarrier();
    if local < count {
        let kind = kind_of(kinds, local);
        var sum = identity(kind);
        for (var lane = 0u; lane < TAKERS; lane += 1u) {
            sum = join(kind, sum, lanes[local * TAKERS + lane]);
        }
        totals[local] = sum;
    }
    workgroupBarrier();
}
