// The blocks of a contact's rows of J, as given: of its normal row, and of its tangent rows.
fn given_block(row: u32, line: u32, side: u32, k: u32) -> vec4r {
    if line == 0u { return jacobian[(2u * row + side) * WIDTH + k]; }
    return tangents[((row * (ROWS - 1u) + line - 1u) * 2u + side) * WIDTH + k];
}
