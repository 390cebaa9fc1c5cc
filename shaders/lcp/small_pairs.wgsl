// One workgroup solves the small problems of all pairs.
fn run_pairs(place: u32, pairs: u32, local: u32) {
    let i = instruction(place);
    for (var slot = local; slot < pairs; slot += WORKGROUP) {
        minimize_block(block_start(slot), block_start(slot + 1u), i.a, i.b, i.c, i.out);
    }
}
