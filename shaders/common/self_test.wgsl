// Each invocation writes a number computed from its index, and the number of rounds of its loop.
var<storage, read_write> out: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) local: u32) {
    out[2u * local] = 1000u * local + 7u;
    var rounds = 0u;
    // A zero that is unknown to the compiler, so the loop cannot be folded.
    let last = ROUNDS + out[100];
    var state = local;
    loop {
        if rounds >= last { break; }
        state = state * 1664525u + 1013904223u;
        rounds += 1u;
    }
    out[2u * local + 1u] = select(rounds, 0u, state == 1u && rounds == 0u);
}
