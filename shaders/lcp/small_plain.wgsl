// Numbers of the device's width are exact enough: there are no second parts.
fn move_body(body: u32, x: u32, low: u32) { move_body_plainly(body, x); }
fn gradient_of(row: u32) -> real { return row_product(row) + vectors[at(Q, row)]; }
