// The sum of the values of the invocations before this one in its workgroup (W. D. Hillis, G. L. Steele, "Data parallel
// algorithms", 1986). All invocations of the workgroup must call it together.
var<workgroup> partial: array<u32, 2u * WORKGROUP>;

fn sum_before(value: u32, local: u32) -> u32 {
    var side = 0u;
    partial[local] = value;
    workgroupBarrier();
    for (var step = 1u; step < WORKGROUP; step *= 2u) {
        var sum = partial[side + local];
        if local >= step { sum += partial[side + local - step]; }
        side = WORKGROUP - side;
        partial[side + local] = sum;
        workgroupBarrier();
    }
    return partial[side + local] - value;
}
