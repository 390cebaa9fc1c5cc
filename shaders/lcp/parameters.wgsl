// What one dispatch does.
struct Parameters {
    rows: u32,
    pairs: u32,
    bodies: u32,
    // Numbers from one vector to the next.
    stride: u32,
    // Workgroups that reduce.
    groups: u32,
    // Looks before those of this stage, over the solve; in one workgroup: whether it confirms a look.
    looks: u32,
    // The place of the first number that this stage makes.
    base: u32,
    // Where the partial sums begin that this stage takes, and those that it makes.
    sums_from: u32,
    sums_into: u32,
    // In one workgroup: turns.
    first: u32,
    last: u32,
    // Zero, which a compiler cannot know.
    zero: u32,
    // The places of a stage's vectors, four in a word, and of its numbers, two in a word.
    vectors: array<vec4<u32>, 2>,
    numbers: array<vec4<u32>, 4>,
}
// Where a stage's vectors and numbers are, as above; the first number that it makes; looks before it, over the solve.
struct Places {
    vectors: array<vec4<u32>, 2>,
    numbers: array<vec4<u32>, 4>,
    base: u32,
    @size(28) looks: u32,
}

var<uniform> parameters: Parameters;

fn at(slot: u32, row: u32) -> u32 { return slot * parameters.stride + row; }
