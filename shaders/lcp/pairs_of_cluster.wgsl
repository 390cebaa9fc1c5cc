// The small problems of the pairs of a cluster: its vectors are in workgroup memory, with local row indices.
fn held(vector: u32, row: u32) -> real { return lanes[vector * MOST_ROWS + row]; }
fn hold(vector: u32, row: u32, number: real) { lanes[vector * MOST_ROWS + row] = number; }
fn inverse_of(row: u32) -> real { return vectors[at(INVERSE, row_of[row])]; }
fn coupling_of(row: u32) -> real { return vectors[at(COUPLING, row_of[row])]; }
fn entry_place(row: u32) -> u32 { return row_of[row] * MOST_EXACT; }
