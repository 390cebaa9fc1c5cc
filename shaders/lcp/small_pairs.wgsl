// One workgroup solves the small problems of all pairs: pairs with one or two rows, pairs with three, then all others,
// so that a driver without branches rarely executes the rare cases.
fn rows_of_slot(slot: u32) -> u32 { return block_start(slot + 1u) - block_start(slot); }

// The next slot of this invocation, from one on, whose pair has this number of rows.
fn next_slot(first: u32, pairs: u32, least: u32, most: u32) -> u32 {
    var slot = first;
    for (; slot < pairs; slot += WORKGROUP) {
        let rows = rows_of_slot(slot);
        if rows >= least && rows <= most { break; }
    }
    return slot;
}

fn run_pairs(x: u32, w: u32, g: u32, out: u32, pairs: u32, local: u32) {
    for (var slot = local; slot < pairs; slot += WORKGROUP) {
        let first = block_start(slot);
        let rows = block_start(slot + 1u) - first;
        if rows == 1u || rows == 2u { minimize_few(first, rows == 2u, x, w, g, out); }
    }
    for (var slot = next_slot(local, pairs, 3u, 3u); slot < pairs; slot = next_slot(slot + WORKGROUP, pairs, 3u, 3u)) {
        let first = block_start(slot);
        if !keep_wanted(first, first + 3u, x, w, g, out) { minimize_three(first, x, w, g, out); }
    }
    for (var slot = next_slot(local, pairs, 4u, NONE); slot < pairs; slot = next_slot(slot + WORKGROUP, pairs, 4u, NONE)) {
        let first = block_start(slot);
        let last = block_start(slot + 1u);
        if !keep_wanted(first, last, x, w, g, out) { minimize_parts(first, last, x, w, g, out); }
    }
}
