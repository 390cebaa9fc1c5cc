// The small problems of all pairs, with global vectors.
fn held(vector: u32, row: u32) -> real { return vectors[at(vector, row)]; }
fn hold(vector: u32, row: u32, number: real) { vectors[at(vector, row)] = number; }
fn inverse_of(row: u32) -> real { return vectors[at(INVERSE, row)]; }
fn coupling_of(row: u32) -> real { return vectors[at(COUPLING, row)]; }
fn entry_place(row: u32) -> u32 { return row * MOST_EXACT; }
