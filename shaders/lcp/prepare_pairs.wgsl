// The blocks of A that belong to pairs. For pairs of two rows B_01 and B_00 / det B: the determinant is computed from
// the rest of one row without its part along the other, because a c - b b loses it where the rows are nearly parallel.
// For pairs of more rows all of B.
var<storage, read> block_start: array<u32>;
var<storage, read> pair: array<vec2<u32>>;
var<storage, read> jacobian: array<vec4r>;
var<storage, read_write> vectors: array<real>;
var<storage, read_write> entries: array<real>;
var<storage, read_write> span: array<u32>;

fn alive(row: u32) -> bool { return vectors[at(INVERSE, row)] > 0.0; }

// Row j minus `part` of row i: its product with row j. The bodies of the rows may be in either order.
fn left_over(i: u32, j: u32, part: real) -> vec2r {
    let turned = select(0u, 1u, any(pair[i] != pair[j]));
    var product = real(0.0);
    var left = real(0.0);
    for (var side = 0u; side < 2u; side += 1u) {
        for (var k = 0u; k < WIDTH; k += 1u) {
            let other = jacobian[(2u * i + (side ^ turned)) * WIDTH + k];
            let own = jacobian[(2u * j + side) * WIDTH + k];
            let across = own - part * other;
            product += dot(own, other);
            left += dot(across, across);
        }
    }
    return vec2r(product, left);
}

fn diagonal_of_block(row: u32) -> real {
    return select(real(1.0), vectors[at(DIAGONAL, row)] * SHIFT, alive(row));
}

fn prepare_two(i: u32) {
    let j = i + 1u;
    var b = real(0.0);
    var det = diagonal_of_block(i) * diagonal_of_block(j);
    if alive(i) && alive(j) {
        let a = vectors[at(DIAGONAL, i)];
        b = left_over(i, j, real(0.0)).x;
        det = a * (left_over(i, j, b / a).y + SHIFT_OF_DETERMINANT * vectors[at(DIAGONAL, j)]);
    }
    vectors[at(COUPLING, i)] = b;
    vectors[at(COUPLING, j)] = diagonal_of_block(i) / det;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let slot = invocation(group, groups, local);
    if slot >= parameters.pairs { return; }
    let first = block_start[slot];
    let rows = block_start[slot + 1u] - first;
    for (var i = 0u; i < rows; i += 1u) {
        span[first + i] = select(first + rows, (first + rows) | FIRST_OF_PAIR, i == 0u);
    }
    if rows == 2u { prepare_two(first); }
    if rows < 3u { return; }
    let parts = (rows + MOST_EXACT - 1u) / MOST_EXACT;
    let size = (rows + parts - 1u) / parts;
    for (var i = 0u; i < rows; i += 1u) {
        let row = first + i;
        let base = i / size * size;
        for (var j = base; j < i; j += 1u) {
            entries[row * MOST_EXACT + j - base] = left_over(first + j, row, real(0.0)).x;
        }
        entries[row * MOST_EXACT + i - base] = diagonal_of_block(row);
    }
}
