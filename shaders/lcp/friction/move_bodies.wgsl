// The velocity J^T x of every body, from the blocks gathered in the order of the bodies' lists.
fn move_bodies(x: u32, first: u32, step: u32) {
    for (var body = first; body < parameters.bodies; body += step) {
        let last = incidence_start[body + 1u];
        var sum = vec4r();
        var turn = vec4r();
        for (var place = incidence_start[body]; place < last; place += 1u) {
            let numbers = vectors[at(x, incidence[place] / 2u)];
            for (var line = 0u; line < ROWS; line += 1u) {
                let block = (place * ROWS + line) * WIDTH;
                sum += numbers[line] * gathered[block];
                if WIDTH == 2u { turn += numbers[line] * gathered[block + 1u]; }
            }
        }
        velocity[body * WIDTH] = sum;
        if WIDTH == 2u { velocity[body * WIDTH + 1u] = turn; }
    }
}
