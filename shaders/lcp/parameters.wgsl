// What one dispatch does. Instructions and operations are places in the program, two words of four each and one.
struct Parameters {
    rows: u32,
    pairs: u32,
    bodies: u32,
    // Numbers from one vector to the next.
    stride: u32,
    // Instructions before and after the one for pairs, which stands at `middle`.
    begin: u32,
    middle: u32,
    end: u32,
    // The vectors of a product.
    x: u32,
    out: u32,
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
}
@group(0) @binding(0) var<uniform> parameters: Parameters;

fn at(slot: u32, row: u32) -> u32 { return slot * parameters.stride + row; }
