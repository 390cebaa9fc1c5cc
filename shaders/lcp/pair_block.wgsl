// The small problem of one pair, argmin over x + c >= 0 of g . c + 1/2 (c - w) . B (c - w), where B is the block of A
// with a relative regularization. It computes changes instead of positions, so that small ones are exact. Zero rows
// of A stay. One and two rows in closed form, more by the active set method of Lawson and Hanson. A pair with more than
// MOST_EXACT rows is divided into parts; with the blocks times the number of parts, which is at least B, the step still
// descends.
const ENTRIES: u32 = 36u;

// B of pairs with more than two rows: MOST_EXACT numbers a row, the entries with the earlier rows of its part and with
// itself. They are in `entries`; the kernel defines the position of a row's entries (`entry_place`) and of vectors
// (`held`).

// An entry of an optional vector.
fn number_of(vector: u32, row: u32) -> real {
    if vector == NONE { return 0.0; }
    return held(vector, row);
}

// One row, or two.
fn minimize_few(row: u32, two: bool, x: u32, w: u32, g: u32, out: u32) {
    let other = select(row, row + 1u, two);
    let start = vec2r(held(x, row), held(x, other));
    let lowest = vec2r(cone_change_to_bound(start.x), cone_change_to_bound(start.y));
    let wanted = vec2r(number_of(w, row), number_of(w, other));
    let inverse = vec2r(inverse_of(row), inverse_of(other));
    let slope = vec2r(number_of(g, row), number_of(g, other));
    // B_01 and B_00 / det B.
    let b = coupling_of(row);
    let inverse_schur = coupling_of(other);
    let s = select(vec2r(), slope, inverse > vec2r());
    let ac = select(vec2r(1.0), SHIFT / inverse, inverse > vec2r());
    let alone = cone_change(wanted.x - s.x / ac.x, start.x);
    // By elimination: the first change compensates the rounding error of the second, unlike with Cramer's rule.
    let change = (b / ac.x * s.x - s.y) * inverse_schur;
    let both = wanted + vec2r(-(s.x + b * change) / ac.x, change);
    // One row with the other at zero.
    let y = wanted - lowest;
    let first = cone_change(wanted.x + (b * y.y - s.x) / ac.x, start.x);
    let second = cone_change(wanted.y + (b * y.x - s.y) / ac.y, start.y);
    let rising = cone_contains(s.x - ac.x * y.x + b * (second - wanted.y));
    let one = select(vec2r(first, lowest.y), vec2r(lowest.x, second), rising);
    let best = select(one, both, cone_allows(both.x, start.x) && cone_allows(both.y, start.y));
    hold(out, row, select(alone, best.x, two));
    if two {
        hold(out, other, best.y);
    }
}

fn triangle(i: u32, j: u32) -> u32 {
    let larger = max(i, j);
    return larger * (larger + 1u) / 2u + min(i, j);
}

fn has(rows: u32, i: u32) -> bool { return (rows & (1u << i)) != 0u; }

// Entry of B of the part that begins at a row.
fn entry(first: u32, i: u32, j: u32) -> real {
    return entries[entry_place(first + max(i, j)) + min(i, j)];
}

fn slope_of(row: u32, g: u32, step: real) -> real {
    return select(real(0.0), step * number_of(g, row), inverse_of(row) > 0.0);
}

fn start_of(row: u32, x: u32, w: u32) -> real { return held(x, row) + number_of(w, row); }

// Data are read in place; only changing values are private.
fn minimize_exactly(first: u32, m: u32, x: u32, w: u32, g: u32, step: real, out: u32) {
    var l: array<real, ENTRIES>;
    // From y = x + w; rows that are not free are held at zero.
    var change: array<real, MOST_EXACT>;
    var aim: array<real, MOST_EXACT>;
    var free = 0u;
    for (var i = 0u; i < m; i += 1u) {
        let start = start_of(first + i, x, w);
        change[i] = cone_lack(start);
        free |= select(0u, 1u << i, cone_is_free(start));
    }
    // The objective never rises; the limit on rounds matters only with rounding errors.
    for (var round = 0u; round < 4u * m + 4u; round += 1u) {
        // The minimum over the free rows, by Cholesky.
        for (var i = 0u; i < m; i += 1u) {
            if !has(free, i) { continue; }
            var right = -slope_of(first + i, g, step);
            var root = real(1.0);
            for (var j = 0u; j < m; j += 1u) {
                var sum = entry(first, i, j);
                if !has(free, j) { right -= sum * change[j]; }
                if !has(free, j) || j > i { continue; }
                let least = LEAST_PIVOT * sum;
                for (var k = 0u; k < j; k += 1u) {
                    if has(free, k) { sum -= l[triangle(i, k)] * l[triangle(j, k)]; }
                }
                // The regularization keeps pivots above that part of the diagonal, up to rounding.
                if i == j {
                    root = sqrt(max(sum, least));
                    sum = root;
                } else {
                    sum /= l[triangle(j, j)];
                    right -= sum * aim[j];
                }
                l[triangle(i, j)] = sum;
            }
            aim[i] = right / root;
        }
        var part = HUGE;
        var hit = m;
        for (var back = 0u; back < m; back += 1u) {
            let i = m - 1u - back;
            if !has(free, i) { continue; }
            var a = aim[i];
            for (var k = i + 1u; k < m; k += 1u) {
                if has(free, k) { a -= l[triangle(k, i)] * aim[k]; }
            }
            a = a / l[triangle(i, i)];
            aim[i] = a;
            let s = start_of(first + i, x, w);
            if cone_is_bound(s + a) {
                let y = s + change[i];
                let bound = select(real(0.0), cone_room(y, a - change[i]), cone_is_free(y));
                if bound <= part {
                    part = bound;
                    hit = i;
                }
            }
        }
        let blocked = hit < m;
        for (var i = 0u; i < m; i += 1u) {
            let s = start_of(first + i, x, w);
            if has(free, i) {
                var c = aim[i];
                if blocked {
                    c = change[i] + part * (c - change[i]);
                    if i == hit || !cone_is_free(s + c) {
                        free &= ~(1u << i);
                        c = -s;
                    }
                }
                change[i] = c;
            }
        }
        if blocked { continue; }
        var steepest = real(0.0);
        var entering = m;
        for (var i = 0u; i < m; i += 1u) {
            if has(free, i) { continue; }
            var rise = slope_of(first + i, g, step);
            var size = abs(rise);
            for (var j = 0u; j < m; j += 1u) {
                let term = entry(first, i, j) * change[j];
                rise += term;
                size += abs(term);
            }
            // A slope from rounding counts as zero.
            rise = (rise + EPSILON * (4.0 * size)) / sqrt(entry(first, i, i));
            if rise < steepest {
                steepest = rise;
                entering = i;
            }
        }
        if entering == m { break; }
        free |= 1u << entering;
    }
    for (var i = 0u; i < m; i += 1u) {
        let start = held(x, first + i);
        let moved = cone_change(number_of(w, first + i) + change[i], start);
        let above = cone_is_free(start_of(first + i, x, w) + change[i]);
        hold(out, first + i, select(cone_change_to_bound(start), moved, above));
    }
}

// a z.x + b z.y = r.x, b z.x + c z.y = r.y.
fn solve_two(a: real, b: real, c: real, r: vec2r) -> vec2r {
    let l = b / a;
    let second = (r.y - l * r.x) / max(c - l * b, LEAST_PIVOT * c);
    return vec2r(r.x / a - l * second, second);
}

// The better of two changes from y, each with its objective, if the second one is allowed.
fn better(best: vec4r, change: vec3r, y: vec3r, slope: vec3r, b: mat3r) -> vec4r {
    let objective = dot(change, slope + 0.5 * (b * change));
    let allowed = cone_contains3(y + change) && objective < best.w;
    return select(best, vec4r(change, objective), allowed);
}

// Three rows, in registers: the best of the minima with some of the rows held at zero.
fn minimize_three(first: u32, x: u32, w: u32, g: u32, out: u32) {
    let y = vec3r(start_of(first, x, w), start_of(first + 1u, x, w), start_of(first + 2u, x, w));
    let slope = vec3r(slope_of(first, g, 1.0), slope_of(first + 1u, g, 1.0), slope_of(first + 2u, g, 1.0));
    // Entries with the second and the third row.
    let at_one = entry_place(first + 1u);
    let at_two = entry_place(first + 2u);
    let d = vec3r(entries[entry_place(first)], entries[at_one + 1u], entries[at_two + 2u]);
    let b01 = entries[at_one];
    let b02 = entries[at_two];
    let b12 = entries[at_two + 1u];
    let b = mat3r(vec3r(d.x, b01, b02), vec3r(b01, d.y, b12), vec3r(b02, b12, d.z));
    // No row free.
    var best = vec4r(-y, dot(y, 0.5 * (b * y) - slope));
    // One.
    let alone = b * y - d * y - slope;
    best = better(best, vec3r(alone.x / d.x, -y.y, -y.z), y, slope, b);
    best = better(best, vec3r(-y.x, alone.y / d.y, -y.z), y, slope, b);
    best = better(best, vec3r(-y.x, -y.y, alone.z / d.z), y, slope, b);
    // Two.
    let xy = solve_two(d.x, b01, d.y, vec2r(b02, b12) * y.z - slope.xy);
    best = better(best, vec3r(xy, -y.z), y, slope, b);
    let xz = solve_two(d.x, b02, d.z, vec2r(b01, b12) * y.y - slope.xz);
    best = better(best, vec3r(xz.x, -y.y, xz.y), y, slope, b);
    let yz = solve_two(d.y, b12, d.z, vec2r(b01, b02) * y.x - slope.yz);
    best = better(best, vec3r(-y.x, yz), y, slope, b);
    // All, by the factors of B.
    let l10 = b01 / d.x;
    let l20 = b02 / d.x;
    let d1 = max(d.y - l10 * b01, LEAST_PIVOT * d.y);
    let l21 = (b12 - l20 * b01) / d1;
    let d2 = max(d.z - l20 * b02 - l21 * l21 * d1, LEAST_PIVOT * d.z);
    let r1 = l10 * slope.x - slope.y;
    let last = (l20 * slope.x - slope.z - l21 * r1) / d2;
    let middle = r1 / d1 - l21 * last;
    best = better(best, vec3r(-slope.x / d.x - l10 * middle - l20 * last, middle, last), y, slope, b);
    for (var i = 0u; i < 3u; i += 1u) {
        let start = held(x, first + i);
        let moved = cone_change(number_of(w, first + i) + best[i], start);
        hold(out, first + i, select(cone_change_to_bound(start), moved, cone_is_free(y[i] + best[i])));
    }
}

// Without a slope, w is the solution if it gives no negative multiplier. One and two rows need no special case.
fn is_inside(first: u32, last: u32, x: u32, w: u32, g: u32) -> bool {
    let many = last - first > 2u && g == NONE;
    var inside = many;
    for (var row = select(last, first, many); row < last; row += 1u) {
        inside = inside && cone_contains(start_of(row, x, w));
    }
    return inside;
}

// If w is the solution, it is used.
fn keep_wanted(first: u32, last: u32, x: u32, w: u32, g: u32, out: u32) -> bool {
    let inside = is_inside(first, last, x, w, g);
    for (var row = select(last, first, inside); row < last; row += 1u) {
        hold(out, row, number_of(w, row));
    }
    return inside;
}

// More than three rows, in parts of which each is solved exactly.
fn minimize_parts(first: u32, last: u32, x: u32, w: u32, g: u32, out: u32) {
    let rows = last - first;
    let parts = (rows + MOST_EXACT - 1u) / MOST_EXACT;
    let size = (rows + parts - 1u) / parts;
    for (var row = first; row < last; row += size) {
        minimize_exactly(row, min(size, last - row), x, w, g, 1.0 / real(parts), out);
    }
}

// Rare cases are in loops with few iterations, because drivers without branches execute everything else.
fn minimize_block(first: u32, last: u32, x: u32, w: u32, g: u32, out: u32) {
    let rows = last - first;
    if rows == 0u { return; }
    if rows <= 2u {
        minimize_few(first, rows == 2u, x, w, g, out);
    }
    let inside = keep_wanted(first, last, x, w, g, out);
    for (var round = select(1u, 0u, rows == 3u && !inside); round < 1u; round += 1u) {
        minimize_three(first, x, w, g, out);
    }
    for (var round = select(1u, 0u, rows > 3u && !inside); round < 1u; round += 1u) {
        minimize_parts(first, last, x, w, g, out);
    }
}
