// The small problem of one pair, as in src/lcp/friction/pairs.rs: one contact exactly, several by a few sweeps of block
// Gauss-Seidel. What a contact's change does to the others goes over the velocities of the two bodies, so no blocks
// between contacts are needed. One of w and g is missing and counts as zero; `out` may be w.

struct Velocities {
    linear: array<vec4r, 2>,
    angular: array<vec4r, 2>,
}

fn held(vector: u32, row: u32) -> vec3r {
    if vector == NONE { return vec3r(); }
    return vectors[at(vector, row)].xyz;
}

// A block of a contact's row of J. The first side is that of the body with the lower number.
fn block_place(row: u32, line: u32, side: u32) -> u32 {
    return row * UNIT_WORDS + BLOCK_WORDS + (2u * line + side) * WIDTH;
}

// J v of a contact.
fn slopes_of(row: u32, v: ptr<function, Velocities>) -> vec3r {
    var slopes = vec3r();
    for (var line = 0u; line < ROWS; line += 1u) {
        var sum = real(0.0);
        for (var side = 0u; side < 2u; side += 1u) {
            let place = block_place(row, line, side);
            sum += dot(units[place], (*v).linear[side]);
            if WIDTH == 2u { sum += dot(units[place + 1u], (*v).angular[side]); }
        }
        slopes[line] = sum;
    }
    return slopes;
}

// v += J^T change.
fn add_change(row: u32, change: vec3r, v: ptr<function, Velocities>) {
    for (var line = 0u; line < ROWS; line += 1u) {
        for (var side = 0u; side < 2u; side += 1u) {
            let place = block_place(row, line, side);
            (*v).linear[side] += change[line] * units[place];
            if WIDTH == 2u { (*v).angular[side] += change[line] * units[place + 1u]; }
        }
    }
}

// What is added to the diagonal of a contact's block of A.
fn added_to_diagonal(row: u32) -> vec3r {
    let diagonal = vectors[at(DIAGONAL, row)].xyz;
    let largest = max(diagonal.x, max(diagonal.y, diagonal.z));
    return vectors[at(COMPLIANCE_AT, row)].xyz + vec3r(REGULARIZATION * largest);
}

fn minimize_alone(row: u32, x: u32, w: u32, g: u32, out: u32) {
    let friction = vectors[at(INVERSE, row)];
    let start = held(x, row);
    let wanted = held(w, row);
    let base = unit_base(row);
    var change = vec3r();
    if g != NONE {
        if friction.w > 0.0 { change = contact_change(base, friction.x, start, held(g, row)); }
    } else {
        let aim = start + wanted;
        let near = friction_project(aim, friction.x);
        change = wanted;
        if any(near != aim) {
            change = near - start;
            if friction.w > 0.0 {
                let rise = times_block(base, near - aim);
                change += contact_change(base, friction.x, near, rise);
            }
        }
    }
    vectors[at(out, row)] = vec4r(friction_displacement(start, change, friction.x), 0.0);
}

// The changes from x + w are in SCRATCH_AT until the end.
fn minimize_several(first: u32, last: u32, x: u32, w: u32, g: u32, out: u32) {
    var v = Velocities();
    var inside = true;
    for (var row = first; row < last; row += 1u) {
        var change = vec3r();
        if w != NONE {
            let aim = held(x, row) + held(w, row);
            change = friction_project(aim, vectors[at(INVERSE, row)].x) - aim;
            inside = inside && all(change == vec3r());
            add_change(row, change, &v);
        }
        vectors[at(SCRATCH_AT, row)] = vec4r(change, 0.0);
    }
    var most = real(0.0);
    for (var sweep = select(0u, SWEEPS, inside && g == NONE); sweep < SWEEPS; sweep += 1u) {
        var farthest = real(0.0);
        for (var row = first; row < last; row += 1u) {
            let friction = vectors[at(INVERSE, row)];
            if !(friction.w > 0.0) { continue; }
            let before = vectors[at(SCRATCH_AT, row)].xyz;
            let start = held(x, row) + held(w, row) + before;
            let rise = held(g, row) + slopes_of(row, &v) + added_to_diagonal(row) * before;
            let change = contact_change(unit_base(row), friction.x, start, rise);
            vectors[at(SCRATCH_AT, row)] = vec4r(before + change, 0.0);
            add_change(row, change, &v);
            farthest = max(farthest, friction.z * sqrt(dot(change, change)));
        }
        most = max(most, farthest);
        if !(farthest > SETTLED * most) { break; }
    }
    for (var row = first; row < last; row += 1u) {
        let change = held(w, row) + vectors[at(SCRATCH_AT, row)].xyz;
        vectors[at(out, row)] = vec4r(friction_displacement(held(x, row), change, vectors[at(INVERSE, row)].x), 0.0);
    }
}

fn minimize_block(first: u32, last: u32, x: u32, w: u32, g: u32, out: u32) {
    let rows = last - first;
    if rows == 1u { minimize_alone(first, x, w, g, out); }
    if rows > 1u { minimize_several(first, last, x, w, g, out); }
}
