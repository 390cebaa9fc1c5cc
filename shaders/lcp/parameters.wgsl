// What one dispatch does. Stages and operations on numbers are places in the program.
struct Parameters {
    rows: u32,
    pairs: u32,
    bodies: u32,
    // Numbers from one vector to the next.
    stride: u32,
    // The vector of a pass over the bodies.
    x: u32,
    // Whether a product is a gradient.
    add_q: u32,
    // The reductions of this dispatch, and the kinds of all, two bits each.
    reduction: u32,
    reductions: u32,
    kinds: u32,
    // Workgroups that reduce.
    groups: u32,
    // Operations on numbers; in one workgroup: stages.
    first: u32,
    last: u32,
    unused: vec4<u32>,
    // The vectors and numbers of a stage.
    vectors: array<vec4<u32>, 8>,
    numbers: array<vec4<u32>, 4>,
}
@group(0) @binding(0) var<uniform> parameters: Parameters;

fn at(slot: u32, row: u32) -> u32 { return slot * parameters.stride + row; }
