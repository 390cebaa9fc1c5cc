// The sum of the displacements of a row's clusters, in their order; a row in no cluster keeps its value.
fn sum_of_parts(row: u32, kept: real) -> real {
    let last = part_start[row + 1u];
    var sum = real(0.0);
    for (var part = part_start[row]; part < last; part += 1u) { sum += displacement[part]; }
    return select(kept, sum, part_start[row] < last);
}
