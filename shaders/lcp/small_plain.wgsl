// Scalars of the device's precision are exact enough: there are no second parts.
fn move_body(body: u32, x: u32, second: u32) { move_body_plainly(body, x); }
fn product_of(row: u32, q: real) -> real { return row_product(row) + q; }
