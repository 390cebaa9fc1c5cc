// The solver's data of each contact: q, the diagonal of A, the compliances, the coefficient, and the start. The tape
// makes the rest from these.
var<storage, read> jacobian: array<vec4r>;
var<storage, read> tangents: array<vec4r>;
var<storage, read> offset: array<real>;
// Two a contact: its coefficient, its number of rows and the offsets of its slips; its compliances.
var<storage, read> contacts: array<vec4r>;
var<storage, read> gammas: array<vec4r>;
var<storage, read_write> vectors: array<vec4r>;

fn square(row: u32, line: u32) -> real {
    var sum = real(0.0);
    for (var side = 0u; side < 2u; side += 1u) {
        for (var k = 0u; k < WIDTH; k += 1u) {
            let block = given_block(row, line, side, k);
            sum += dot(block, block);
        }
    }
    return sum;
}

// A number that is not finite must appear in the residual; an open row would hide it.
fn shown(q: real, diagonal: real) -> real {
    if is_finite(q) && is_finite(diagonal) { return q; }
    return not_a_number();
}

// A contact's coefficient, the most part of a change of its correction that is made, and the scale of its block.
fn friction_of(mu: real, rows: real, own: vec3r) -> vec4r {
    if rows < 2.0 { return vec4r(mu, 1.0, own.x, 0.0); }
    let most = 1.0 + mu * mu * max(own.y, own.z) / own.x;
    return vec4r(mu, most, (own.x + own.y + own.z) / rows, 0.0);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = invocation(group, groups, local);
    if row >= parameters.rows { return; }
    let given = contacts[2u * row];
    var diagonal = vec4r();
    for (var line = 0u; line < ROWS; line += 1u) { diagonal[line] = square(row, line); }
    let compliance = vec4r(contacts[2u * row + 1u].xyz, 0.0);
    let all = diagonal.x + diagonal.y + diagonal.z + compliance.x + compliance.y + compliance.z;
    let slips = vec2r(shown(given.z, all), shown(given.w, all));
    vectors[at(Q, row)] = vec4r(shown(offset[row], all), slips.x, slips.y, 0.0);
    vectors[at(DIAGONAL, row)] = diagonal;
    vectors[at(INVERSE, row)] = friction_of(given.x, given.y, diagonal.xyz + compliance.xyz);
    vectors[at(COMPLIANCE_AT, row)] = compliance;
    vectors[at(CORRECTION_AT, row)] = vec4r();
    vectors[at(SCRATCH_AT, row)] = vec4r();
    vectors[at(X, row)] = vec4r(friction_admit(gammas[row].xyz, given.x), 0.0);
}
