// What the small problems of contacts need (src/lcp/friction/block.rs): the block of A, its inverse, a basis in which
// it and diag(mu^2, -1, -1) are diagonal; and the rows of J, the side of the body with the lower number first.
var<storage, read> block_start: array<u32>;
var<storage, read> pair: array<vec2<u32>>;
var<storage, read> jacobian: array<vec4r>;
var<storage, read> tangents: array<vec4r>;
var<storage, read_write> vectors: array<vec4r>;
var<storage, read_write> units: array<vec4r>;
var<storage, read_write> span: array<u32>;

struct Eigen {
    // Symmetric, by rows.
    m: array<vec3r, 3>,
    // The vectors are its columns.
    v: array<vec3r, 3>,
}

// The rotation that makes m[p][q] zero (G. H. Golub, C. F. Van Loan, Matrix Computations, section 8.5).
fn rotate(e: ptr<function, Eigen>, p: u32, q: u32) {
    let off = (*e).m[p][q];
    let mpp = (*e).m[p][p];
    let mqq = (*e).m[q][q];
    if abs(off) <= TINY + NEGLIGIBLE * sqrt(abs(mpp) * abs(mqq)) {
        (*e).m[p][q] = 0.0;
        (*e).m[q][p] = 0.0;
        return;
    }
    let half = (mqq - mpp) / (2.0 * off);
    let t = select(real(-1.0), real(1.0), half >= 0.0) / (abs(half) + sqrt(1.0 + half * half));
    let c = 1.0 / sqrt(1.0 + t * t);
    let s = t * c;
    let r = 3u - p - q;
    let mp = (*e).m[r][p];
    let mq = (*e).m[r][q];
    (*e).m[p][p] = mpp - t * off;
    (*e).m[q][q] = mqq + t * off;
    (*e).m[p][q] = 0.0;
    (*e).m[q][p] = 0.0;
    (*e).m[r][p] = c * mp - s * mq;
    (*e).m[r][q] = s * mp + c * mq;
    (*e).m[p][r] = (*e).m[r][p];
    (*e).m[q][r] = (*e).m[r][q];
    for (var i = 0u; i < 3u; i += 1u) {
        let vp = (*e).v[i][p];
        let vq = (*e).v[i][q];
        (*e).v[i][p] = c * vp - s * vq;
        (*e).v[i][q] = s * vp + c * vq;
    }
}

fn diagonalize(e: ptr<function, Eigen>) {
    for (var sweep = 0u; sweep < MOST_SWEEPS; sweep += 1u) {
        if (*e).m[0][1] == 0.0 && (*e).m[0][2] == 0.0 && (*e).m[1][2] == 0.0 { return; }
        rotate(e, 0u, 1u);
        rotate(e, 0u, 2u);
        rotate(e, 1u, 2u);
    }
}

// L^-1 of B = L L^T, by rows.
fn inverse_of_factor(b: array<vec3r, 3>) -> array<vec3r, 3> {
    let l00 = sqrt(b[0].x);
    let l10 = b[1].x / l00;
    let l20 = b[2].x / l00;
    let l11 = sqrt(max(b[1].y - l10 * l10, LEAST_PIVOT * b[1].y));
    let l21 = (b[2].y - l20 * l10) / l11;
    let l22 = sqrt(max(b[2].z - l20 * l20 - l21 * l21, LEAST_PIVOT * b[2].z));
    let i0 = 1.0 / l00;
    let i1 = 1.0 / l11;
    let i2 = 1.0 / l22;
    let i10 = -l10 * i0 * i1;
    let last = vec3r(-(l20 * i0 + l21 * i10) * i2, -l21 * i1 * i2, i2);
    return array<vec3r, 3>(vec3r(i0, 0.0, 0.0), vec3r(i10, i1, 0.0), last);
}

fn form(x: vec3r, y: vec3r, mu: real) -> real { return mu * mu * x.x * y.x - x.y * y.y - x.z * y.z; }

fn write_block(row: u32, b: array<vec3r, 3>, mu: real) {
    let root = inverse_of_factor(b);
    var eigen: Eigen;
    for (var i = 0u; i < 3u; i += 1u) {
        for (var j = 0u; j < 3u; j += 1u) {
            eigen.m[i][j] = form(rows_of(root, i), rows_of(root, j), mu);
            eigen.v[i][j] = select(real(0.0), real(1.0), i == j);
        }
    }
    diagonalize(&eigen);
    let spectrum = vec3r(eigen.m[0][0], eigen.m[1][1], eigen.m[2][2]);
    let first = spectrum.x >= spectrum.y && spectrum.x >= spectrum.z;
    let plus = select(select(1u, 2u, spectrum.z > spectrum.y), 0u, first);
    let base = row * UNIT_WORDS;
    units[base] = vec4r(b[0], b[1].y);
    for (var nth = 0u; nth < 3u; nth += 1u) {
        let k = (plus + nth) % 3u;
        var vector = eigen.v[0][k] * root[0] + eigen.v[1][k] * root[1] + eigen.v[2][k] * root[2];
        if nth == 0u && vector.x < 0.0 { vector = -vector; }
        let number = select(-eigen.m[k][k], eigen.m[k][k], nth == 0u);
        units[base + 3u + nth] = vec4r(vector, max(number, real(0.0)));
    }
    // L^-T L^-1.
    let c0 = vec3r(root[0].x, root[1].x, root[2].x);
    let c1 = vec3r(root[0].y, root[1].y, root[2].y);
    let c2 = vec3r(root[0].z, root[1].z, root[2].z);
    units[base + 1u] = vec4r(b[1].z, b[2].z, dot(c0, c0), dot(c0, c1));
    units[base + 2u] = vec4r(dot(c0, c2), dot(c1, c1), dot(c1, c2), dot(c2, c2));
}

fn rows_of(m: array<vec3r, 3>, row: u32) -> vec3r { return select(select(m[2], m[1], row == 1u), m[0], row == 0u); }

fn product_of_rows(row: u32, i: u32, j: u32) -> real {
    var sum = real(0.0);
    for (var side = 0u; side < 2u; side += 1u) {
        for (var k = 0u; k < WIDTH; k += 1u) {
            sum += dot(given_block(row, i, side, k), given_block(row, j, side, k));
        }
    }
    return sum;
}

fn prepare_contact(row: u32) {
    let turned = select(0u, 1u, pair[row].x > pair[row].y);
    let blocks = row * UNIT_WORDS + BLOCK_WORDS;
    for (var line = 0u; line < ROWS; line += 1u) {
        for (var side = 0u; side < 2u; side += 1u) {
            for (var k = 0u; k < WIDTH; k += 1u) {
                units[blocks + (2u * line + side) * WIDTH + k] = given_block(row, line, side ^ turned, k);
            }
        }
    }
    let friction = vectors[at(INVERSE, row)];
    var b = array<vec3r, 3>(vec3r(1.0, 0.0, 0.0), vec3r(0.0, 1.0, 0.0), vec3r(0.0, 0.0, 1.0));
    // What is not live is not used, and its matrix may be zero.
    if friction.w > 0.0 {
        let compliance = vectors[at(COMPLIANCE_AT, row)];
        let diagonal = vectors[at(DIAGONAL, row)];
        let largest = max(diagonal.x, max(diagonal.y, diagonal.z));
        for (var i = 0u; i < 3u; i += 1u) {
            // Rows that are idle have an entry of their own.
            let idle = i >= ROWS || (i > 0u && diagonal[i] + compliance[i] == 0.0);
            for (var j = 0u; j < 3u; j += 1u) {
                b[i][j] = 0.0;
                if i < ROWS && j < ROWS { b[i][j] = product_of_rows(row, i, j); }
            }
            b[i][i] += select(compliance[i], real(1.0), idle) + REGULARIZATION * largest;
        }
    }
    write_block(row, b, friction.x);
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
    let last = block_start[slot + 1u];
    for (var row = first; row < last; row += 1u) {
        span[row] = select(last, last | FIRST_OF_PAIR, row == first);
        prepare_contact(row);
    }
}
