// q + J v of a row, from velocities in two parts.
fn row_product_exactly(row: u32, q: real) -> real {
    let bodies = pair_of(row);
    var sum = TwoParts();
    for (var k = 0u; k < WIDTH; k += 1u) {
        let place = bodies.x * WIDTH + k;
        sum = add_product(sum, jacobian[2u * row * WIDTH + k], velocity[place], velocity_rest[place]);
    }
    if bodies.y < parameters.bodies {
        for (var k = 0u; k < WIDTH; k += 1u) {
            let place = bodies.y * WIDTH + k;
            sum = add_product(sum, jacobian[(2u * row + 1u) * WIDTH + k], velocity[place], velocity_rest[place]);
        }
    }
    return all_of(q, sum);
}
