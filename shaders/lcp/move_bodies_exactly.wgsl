// The velocity J^T (x + low) of every body in two parts; `low` may be missing.
fn move_bodies_exactly(x: u32, low: u32, first: u32, step: u32) {
    for (var body = first; body < parameters.bodies; body += step) {
        let last = incidence_start[body + 1u];
        var sum = TwoParts();
        var turn = TwoParts();
        for (var place = incidence_start[body]; place < last; place += 1u) {
            let row = incidence[place] / 2u;
            let number = vec4r(vectors[at(x, row)]);
            var rest = vec4r();
            if low != NONE { rest = vec4r(vectors[at(low, row)]); }
            sum = add_product(sum, gathered[place * WIDTH], number, rest);
            if WIDTH == 2u {
                turn = add_product(turn, gathered[place * WIDTH + 1u], number, rest);
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
}
