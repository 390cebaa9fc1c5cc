// The solvers' data of each row: q, the diagonal of A, its majorant, and the start. The tape inverts the
// diagonals.
var<storage, read> pair: array<vec2<u32>>;
var<storage, read> jacobian: array<vec4r>;
var<storage, read> offset: array<real>;
var<storage, read> gamma: array<real>;
var<storage, read> incidence_start: array<u32>;
var<storage, read_write> vectors: array<real>;

fn square(block: u32) -> real {
    var sum = real(0.0);
    for (var k = 0u; k < WIDTH; k += 1u) {
        sum += dot(jacobian[block * WIDTH + k], jacobian[block * WIDTH + k]);
    }
    return sum;
}

// A body without mobility has no list.
fn count(body: u32) -> real {
    if body >= parameters.bodies { return 0.0; }
    return real(incidence_start[body + 1u] - incidence_start[body]);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = invocation(group, groups, local);
    if row >= parameters.rows { return; }
    let squares = vec2r(square(2u * row), square(2u * row + 1u));
    let diagonal = squares.x + squares.y;
    var q = offset[row];
    // A number that is not finite must appear in the residual; an open row would hide it.
    if !is_finite(q) || !is_finite(diagonal) {
        q = -abs(q) - diagonal;
    }
    vectors[at(Q, row)] = q;
    vectors[at(DIAGONAL, row)] = diagonal;
    if MAJORANT != NONE {
        let bodies = pair[row];
        vectors[at(MAJORANT, row)] = count(bodies.x) * squares.x + count(bodies.y) * squares.y;
    }
    vectors[at(X, row)] = cone_admit(gamma[row]);
    if LOW != NONE {
        vectors[at(LOW, row)] = 0.0;
    }
}
