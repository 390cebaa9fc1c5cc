// The small problem of one pair, argmin over y >= 0 of slope . (y - x) + 1/2 (y - x) . B (y - x), solved for y - x, where B is the
// block of A with a relative regularization. One and two rows in closed form, up to MOST_EXACT by the active set method of Lawson
// and Hanson, more by sweeps of projected coordinate steps, none of which rises. Zero rows of A keep x.
const MOST_EXACT: u32 = 8u;
const ENTRIES: u32 = 36u;

fn alive(row: u32) -> bool { return vectors[at(INVERSE, row)] > 0.0; }

// A_ij of two rows of a pair, named in either order.
fn entry(i: u32, j: u32) -> real {
    let turned = select(0u, 1u, any(pair_of(i) != pair_of(j)));
    var sum = real(0.0);
    for (var side = 0u; side < 2u; side += 1u) {
        for (var k = 0u; k < WIDTH; k += 1u) {
            sum += dot(jacobian[(2u * i + side) * WIDTH + k], jacobian[(2u * j + (side ^ turned)) * WIDTH + k]);
        }
    }
    return sum;
}

fn diagonal_of_block(row: u32) -> real {
    return select(real(1.0), vectors[at(DIAGONAL, row)] * SHIFT, alive(row));
}

fn slope_of(row: u32, g: u32, step: real) -> real {
    return select(real(0.0), step * vectors[at(g, row)], alive(row));
}

fn minimize_single(row: u32, x: u32, g: u32, step: real, out: u32) {
    let change = -slope_of(row, g, step) * vectors[at(INVERSE, row)] / SHIFT;
    vectors[at(out, row)] = max(vectors[at(x, row)] + change, 0.0);
}

// By its four cases. COUPLING holds B_01 and 1 / det B.
fn minimize_double(row: u32, x: u32, g: u32, step: real, out: u32) {
    let a = diagonal_of_block(row);
    let b = vectors[at(COUPLING, row)];
    let c = diagonal_of_block(row + 1u);
    let inverse = vectors[at(COUPLING, row + 1u)];
    let y = vec2r(vectors[at(x, row)], vectors[at(x, row + 1u)]);
    let slope = vec2r(slope_of(row, g, step), slope_of(row + 1u, g, step));
    let both = y + vec2r(b * slope.y - c * slope.x, b * slope.x - a * slope.y) * inverse;
    let first = max(y.x + (b * y.y - slope.x) / a, 0.0);
    let second = max(y.y + (b * y.x - slope.y) / c, 0.0);
    let rising = slope.x - a * y.x + b * (second - y.y) >= 0.0;
    let one = select(vec2r(first, 0.0), vec2r(0.0, second), rising);
    let inside = both.x >= 0.0 && both.y >= 0.0;
    vectors[at(out, row)] = select(one.x, both.x, inside);
    vectors[at(out, row + 1u)] = select(one.y, both.y, inside);
}

fn triangle(i: u32, j: u32) -> u32 {
    let larger = max(i, j);
    return larger * (larger + 1u) / 2u + min(i, j);
}

fn minimize_exactly(first: u32, m: u32, x: u32, g: u32, step: real, out: u32) {
    var b: array<real, ENTRIES>;
    var l: array<real, ENTRIES>;
    var start: array<real, MOST_EXACT>;
    var slope: array<real, MOST_EXACT>;
    var change: array<real, MOST_EXACT>;
    var aim: array<real, MOST_EXACT>;
    var free = 0u;
    for (var i = 0u; i < m; i += 1u) {
        let row = first + i;
        start[i] = vectors[at(x, row)];
        slope[i] = slope_of(row, g, step);
        change[i] = max(-start[i], 0.0);
        free |= select(0u, 1u << i, start[i] > 0.0);
        for (var j = 0u; j < i; j += 1u) {
            b[triangle(i, j)] = entry(row, first + j);
        }
        b[triangle(i, i)] = diagonal_of_block(row);
    }
    // The objective never rises; the bound on rounds only matters to rounding.
    for (var round = 0u; round < 4u * m + 4u; round += 1u) {
        for (var i = 0u; i < m; i += 1u) {
            if (free & (1u << i)) == 0u { change[i] = -start[i]; }
        }
        // The minimum over the free rows, by Cholesky.
        for (var i = 0u; i < m; i += 1u) {
            if (free & (1u << i)) == 0u { continue; }
            var right = -slope[i];
            for (var j = 0u; j < m; j += 1u) {
                if (free & (1u << j)) == 0u { right -= b[triangle(i, j)] * change[j]; }
            }
            for (var j = 0u; j < i; j += 1u) {
                if (free & (1u << j)) == 0u { continue; }
                var sum = b[triangle(i, j)];
                for (var k = 0u; k < j; k += 1u) {
                    if (free & (1u << k)) != 0u { sum -= l[triangle(i, k)] * l[triangle(j, k)]; }
                }
                sum = sum / l[triangle(j, j)];
                l[triangle(i, j)] = sum;
                right -= sum * aim[j];
            }
            var pivot = b[triangle(i, i)];
            for (var k = 0u; k < i; k += 1u) {
                if (free & (1u << k)) != 0u { pivot -= l[triangle(i, k)] * l[triangle(i, k)]; }
            }
            // The regularization keeps pivots above this part of the diagonal, up to rounding.
            pivot = sqrt(max(pivot, LEAST_PIVOT * b[triangle(i, i)]));
            l[triangle(i, i)] = pivot;
            aim[i] = right / pivot;
        }
        var part = HUGE;
        var hit = m;
        for (var back = 0u; back < m; back += 1u) {
            let i = m - 1u - back;
            if (free & (1u << i)) == 0u { continue; }
            var right = aim[i];
            for (var k = i + 1u; k < m; k += 1u) {
                if (free & (1u << k)) != 0u { right -= l[triangle(k, i)] * aim[k]; }
            }
            aim[i] = right / l[triangle(i, i)];
            if start[i] + aim[i] <= 0.0 {
                let room = start[i] + change[i];
                let bound = select(real(0.0), room / (change[i] - aim[i]), room > 0.0);
                if bound <= part {
                    part = bound;
                    hit = i;
                }
            }
        }
        if hit < m {
            for (var i = 0u; i < m; i += 1u) {
                if (free & (1u << i)) == 0u { continue; }
                change[i] += part * (aim[i] - change[i]);
                if !(start[i] + change[i] > 0.0) || i == hit { free &= ~(1u << i); }
            }
            continue;
        }
        var steepest = real(0.0);
        var entering = m;
        for (var i = 0u; i < m; i += 1u) {
            if (free & (1u << i)) != 0u {
                change[i] = aim[i];
            }
        }
        for (var i = 0u; i < m; i += 1u) {
            if (free & (1u << i)) != 0u { continue; }
            var rise = slope[i];
            var size = abs(rise);
            for (var j = 0u; j < m; j += 1u) {
                let term = b[triangle(i, j)] * change[j];
                rise += term;
                size += abs(term);
            }
            // What rounding makes of nothing is no slope.
            rise = (rise + EPSILON * (4.0 * size)) / sqrt(b[triangle(i, i)]);
            if rise < steepest {
                steepest = rise;
                entering = i;
            }
        }
        if entering == m { break; }
        free |= 1u << entering;
    }
    for (var i = 0u; i < m; i += 1u) {
        vectors[at(out, first + i)] = max(start[i] + change[i], 0.0);
    }
}

// The change stands in `out` until the end. All rows of a pair move the same two bodies, whose motion is kept up to date.
fn minimize_by_sweeps(first: u32, m: u32, x: u32, g: u32, step: real, out: u32) {
    var motion: array<vec4r, 2 * WIDTH>;
    for (var k = 0u; k < 2u * WIDTH; k += 1u) { motion[k] = vec4r(); }
    let named = pair_of(first);
    for (var turn = 0u; turn < SWEEPS * m; turn += 1u) {
        let row = first + turn % m;
        let turned = select(0u, WIDTH, any(pair_of(row) != named));
        let start = vectors[at(x, row)];
        var old = real(0.0);
        var new_change = max(-start, 0.0);
        if turn >= m {
            old = vectors[at(out, row)];
            var rise = slope_of(row, g, step) + REGULARIZATION * vectors[at(DIAGONAL, row)] * old;
            for (var k = 0u; k < 2u * WIDTH; k += 1u) {
                rise += dot(jacobian[2u * row * WIDTH + k], motion[(k + turned) % (2u * WIDTH)]);
            }
            new_change = max(old - rise * vectors[at(INVERSE, row)] / SHIFT, -start);
        }
        for (var k = 0u; k < 2u * WIDTH; k += 1u) {
            motion[(k + turned) % (2u * WIDTH)] += (new_change - old) * jacobian[2u * row * WIDTH + k];
        }
        vectors[at(out, row)] = new_change;
    }
    for (var row = first; row < first + m; row += 1u) {
        vectors[at(out, row)] = max(vectors[at(x, row)] + vectors[at(out, row)], 0.0);
    }
}

fn minimize_block(first: u32, last: u32, x: u32, g: u32, step: real, out: u32) {
    let m = last - first;
    if m == 1u {
        minimize_single(first, x, g, step, out);
    } else if m == 2u {
        minimize_double(first, x, g, step, out);
    } else if m > MOST_EXACT {
        minimize_by_sweeps(first, m, x, g, step, out);
    } else if m > 2u {
        minimize_exactly(first, m, x, g, step, out);
    }
}
