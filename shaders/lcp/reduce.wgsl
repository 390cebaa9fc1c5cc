// Sums of a workgroup, in a fixed order, several at once.
const LANES: u32 = WORKGROUP / REDUCTIONS;

var<workgroup> lanes: array<real, WORKGROUP * REDUCTIONS>;
var<workgroup> sums: array<real, WORKGROUP>;

fn identity(kind: u32) -> real {
    return select(real(0.0), HUGE, kind == LEAST);
}

// The worst is not finite if any is not.
fn join(kind: u32, a: real, b: real) -> real {
    let worst = select(select(select(b, a, a >= b), b, !is_finite(b)), a, !is_finite(a));
    let least = select(a, b, b < a);
    return select(select(worst, least, kind == LEAST), a + b, kind == SUM);
}

fn kind_of(kinds: u32, reduction: u32) -> u32 { return (kinds >> (2u * reduction)) & 3u; }

// Reduces the values of the invocations in `lanes`; then `total` returns each sum to the invocations below REDUCTIONS.
fn reduce(local: u32, kinds: u32) {
    workgroupBarrier();
    let reduction = local / LANES;
    let kind = kind_of(kinds, reduction);
    var sum = identity(kind);
    for (var lane = local % LANES; lane < WORKGROUP; lane += LANES) {
        sum = join(kind, sum, lanes[reduction * WORKGROUP + lane]);
    }
    sums[local] = sum;
    workgroupBarrier();
}

fn total(reduction: u32, kinds: u32) -> real {
    let kind = kind_of(kinds, reduction);
    var sum = identity(kind);
    for (var lane = 0u; lane < LANES; lane += 1u) {
        sum = join(kind, sum, sums[reduction * LANES + lane]);
    }
    return sum;
}
