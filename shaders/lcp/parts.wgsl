// The sum of what the clusters of a row lead to, in their order; a row in none of them keeps its number.
fn sum_of_parts(row: u32, kept: real) -> real {
    let last = part_start[row + 1u];
    var sum = real(0.0);
    for (var part = part_start[row]; part < last; part += 1u) { sum += displacement[part]; }
    return select(kept, sum, part_start[row] < last);
}
