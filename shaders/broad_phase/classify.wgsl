// The size class of every box, zero for a box that touches nothing, and the survey of all classes. The result does not
// depend on the order of its atomics.
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> boxes: array<vec4r>;
var<storage, read_write> classes: array<u32>;
var<storage, read_write> survey: array<atomic<u32>>;

fn is_length(x: real) -> bool {
    return is_finite(x) && x >= 0.0;
}

fn raise(word: u32, reach: u32) {
    // Most boxes do not raise the maximum: a load is cheaper than a contended atomic.
    if atomicLoad(&survey[word]) < reach { atomicMax(&survey[word], reach); }
}

fn mark(word: u32, bits: u32) {
    if (atomicLoad(&survey[word]) & bits) != bits { atomicOr(&survey[word], bits); }
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    var half = boxes[i];
    var remainder = remainders[i].xyz;
    var cell = cells[i].xyz;
    if PLANAR == 1u {
        half.z = 0.0;
        remainder.z = 0.0;
        cell.z = 0;
    }
    classes[i] = 0u;
    let known = is_finite(remainder.x) && is_finite(remainder.y) && is_finite(remainder.z);
    if !(known && is_length(half.x) && is_length(half.y) && is_length(half.z)) { return; }
    if any(cell <= vec3<i32>(-MOST_CELL)) || any(cell >= vec3<i32>(MOST_CELL)) { mark(FAR, 1u); }
    let reach = lattice_reach(half.xyz);
    // A radius that is too small must not assign a box to a level that is too fine.
    var widest = max(reach.x, max(reach.y, reach.z));
    if is_length(half.w) { widest = max(widest, lattice_reach(vec3r(half.w)).x); }
    let class_ = 32u - countLeadingZeros(2u * widest - 1u);
    classes[i] = class_;
    mark(CLASSES, 1u << class_);
    for (var axis = 0u; axis < 3u; axis += 1u) { raise(REACH + 3u * class_ + axis, reach[axis]); }
}
