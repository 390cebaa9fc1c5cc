// The ranges of the rows of pairs.
fn begins_pair(row: u32) -> bool { return row < parameters.rows && span[row] >= FIRST_OF_PAIR; }

// The first row of a pair from this one on.
fn first_from(row: u32) -> u32 {
    if row >= parameters.rows { return parameters.rows; }
    return select(span[row], row, begins_pair(row));
}
