// In one workgroup, the velocity J^T (x + low) of a body in two parts. `second` is the offset of `low` plus one, or
// NONE if it is missing.
fn move_body(body: u32, x: u32, second: u32) {
    let span = entries_of(body);
    var sum = TwoParts();
    var turn = TwoParts();
    for (var place = span.x; place < span.y; place += 1u) {
        let block = lists[place];
        let number = vec4r(vectors[at(x, block / 2u)]);
        var rest = vec4r();
        if second != NONE { rest = vec4r(vectors[at(second - 1u, block / 2u)]); }
        sum = add_product(sum, jacobian[block * WIDTH], number, rest);
        if WIDTH == 2u {
            turn = add_product(turn, jacobian[block * WIDTH + 1u], number, rest);
        }
    }
    sum = rounded(sum);
    velocity[body * WIDTH] = sum.value;
    velocity_rest[body * WIDTH] = sum.rest;
    if WIDTH == 2u {
        turn = rounded(turn);
        velocity[body * WIDTH + 1u] = turn.value;
        velocity_rest[body * WIDTH + 1u] = turn.rest;
    }
}

fn product_of(row: u32, q: real) -> real { return row_product_exactly(row, q); }
