// Products of rows of J. A row has two blocks, one for each body of its pair, of WIDTH vectors of four each. A second
// body with an index beyond all bodies is a surface without mobility: its block is zero, and it has no velocity.

// g of a row without q: its two blocks times the velocities of its bodies.
fn row_product(row: u32) -> real {
    let bodies = pair_of(row);
    var g = real(0.0);
    for (var k = 0u; k < WIDTH; k += 1u) {
        g += dot(jacobian[2u * row * WIDTH + k], velocity[bodies.x * WIDTH + k]);
    }
    if bodies.y >= parameters.bodies { return g; }
    for (var k = 0u; k < WIDTH; k += 1u) {
        g += dot(jacobian[(2u * row + 1u) * WIDTH + k], velocity[bodies.y * WIDTH + k]);
    }
    return g;
}
