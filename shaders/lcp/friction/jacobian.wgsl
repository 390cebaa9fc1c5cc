// J v of a contact: its normal row and its tangent rows. A second body beyond all bodies is a surface: its blocks are
// zero.
fn row_product(row: u32) -> vec4r {
    let bodies = pair[row];
    let first = min(bodies.x, bodies.y);
    let second = max(bodies.x, bodies.y);
    var g = vec4r();
    for (var line = 0u; line < ROWS; line += 1u) {
        let place = row * UNIT_WORDS + BLOCK_WORDS + 2u * line * WIDTH;
        var sum = real(0.0);
        for (var k = 0u; k < WIDTH; k += 1u) { sum += dot(units[place + k], velocity[first * WIDTH + k]); }
        if second < parameters.bodies {
            for (var k = 0u; k < WIDTH; k += 1u) {
                sum += dot(units[place + WIDTH + k], velocity[second * WIDTH + k]);
            }
        }
        g[line] = sum;
    }
    return g;
}
