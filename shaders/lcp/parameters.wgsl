// The parameters of one dispatch.
struct Parameters {
    rows: u32,
    pairs: u32,
    bodies: u32,
    // The stride between vectors.
    stride: u32,
    // Workgroups that reduce.
    groups: u32,
    // Checks before those of this stage, over the solve; in one workgroup: whether it confirms a check.
    looks: u32,
    // The offset of the first scalar that this stage computes.
    base: u32,
    // The offsets of the partial sums that this stage reads, and of those that it writes.
    sums_from: u32,
    sums_into: u32,
    // In one workgroup: turns.
    first: u32,
    last: u32,
    // A zero that is unknown to the compiler.
    zero: u32,
    // The offsets of a stage's vectors, four per word, and of its scalars, two per word.
    vectors: array<vec4<u32>, 2>,
    numbers: array<vec4<u32>, 4>,
}
// The offsets of a stage's vectors and scalars, as above; the first scalar that it computes; the checks before it, over
// the solve.
struct Places {
    vectors: array<vec4<u32>, 2>,
    numbers: array<vec4<u32>, 4>,
    base: u32,
    @size(28) looks: u32,
}

var<uniform> parameters: Parameters;

fn at(slot: u32, row: u32) -> u32 { return slot * parameters.stride + row; }
