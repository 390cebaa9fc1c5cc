// Copies keys and values to the range of their digit. Keys with the same digit keep their order.
var<storage, read> keys: array<u32>;
var<storage, read> values: array<u32>;
// The offset of the keys of every digit and block, sorted by digit.
var<storage, read> starts: array<u32>;
var<storage, read_write> sorted_keys: array<u32>;
var<storage, read_write> sorted_values: array<u32>;

// By digit, then by invocation: first the count, then the next position in the sorted block.
var<workgroup> place: array<u32, DIGITS * WORKGROUP>;
// The offset to add to a position in the sorted block.
var<workgroup> base: array<u32, DIGITS>;

fn digit(i: u32) -> u32 {
    return (keys[i] >> parameters.shift) & parameters.mask;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = group_index(group, groups);
    let first = (block * WORKGROUP + local) * ITEMS;
    let end = min(first + ITEMS, parameters.n);
    for (var d = 0u; d < DIGITS; d += 1u) { place[d * WORKGROUP + local] = 0u; }
    for (var i = first; i < end; i += 1u) { place[digit(i) * WORKGROUP + local] += 1u; }
    workgroupBarrier();
    var own = 0u;
    for (var k = local * DIGITS; k < (local + 1u) * DIGITS; k += 1u) { own += place[k]; }
    var sum = sum_before(own, local);
    for (var k = local * DIGITS; k < (local + 1u) * DIGITS; k += 1u) {
        let count = place[k];
        place[k] = sum;
        sum += count;
    }
    workgroupBarrier();
    if local < DIGITS { base[local] = starts[local * parameters.blocks + block] - place[local * WORKGROUP]; }
    workgroupBarrier();
    for (var i = first; i < end; i += 1u) {
        let k = digit(i) * WORKGROUP + local;
        let to = base[k / WORKGROUP] + place[k];
        place[k] += 1u;
        sorted_keys[to] = keys[i];
        sorted_values[to] = values[i];
    }
}
