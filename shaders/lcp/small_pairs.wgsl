// The small problems of all pairs, by one workgroup.
fn run_pairs(kind: u32, place: u32, local: u32) {
    if kind != PAIRS_STAGE { return; }
    let i = instruction(place);
    for (var slot = local; slot < parameters.pairs; slot += WORKGROUP) {
        minimize_block(block_start(slot), block_start(slot + 1u), i.a, i.b, i.s, i.out);
    }
}
