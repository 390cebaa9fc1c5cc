// Moves the offset of the first row of each pair that violates, so that the row is exact at the trial:
//
//     q += Phi(C(U)) - g(U),   g(U) = q + J v,
//
// if that row was made from the pair's near surfaces, has the direction of the row that the overlap would have, and
// becomes tighter. Such a pair is near then and no longer violating: the others get a row.

var<storage, read> row_start: array<u32>;
var<storage, read> is_first: array<real>;
var<storage, read> row_pairs: array<vec2<u32>>;
var<storage, read> jacobian: array<vec4r>;
var<storage, read> velocities: array<vec4r>;
var<storage, read> motions: array<vec4r>;
var<storage, read_write> q: array<real>;
var<storage, read_write> contacts: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs || contacts[3u * p + 2u].w < VIOLATING { return; }
    let row = row_start[p];
    if row == row_start[p + 1u] || is_first[row] == 0.0 { return; }
    let contact = contacts[3u * p];
    let a = share(row, 0u, row_pairs[row].x, -contact.xyz, contacts[3u * p + 1u].xyz);
    // A surface's block is zero. In rows surfaces come after all bodies.
    var b = Share(real(0.0), real(0.0), real(0.0), real(0.0));
    if row_pairs[row].y < parameters.bodies {
        b = share(row, 1u, row_pairs[row].y, contact.xyz, contacts[3u * p + 2u].xyz);
    }
    let g = q[row] + (a.g + b.g);
    let aligned = a.both + b.both > LEAST_ALIGNED * sqrt((a.own + b.own) * (a.there + b.there));
    if aligned && contact.w < g {
        q[row] += contact.w - g;
        contacts[3u * p + 2u].w = NEAR;
    }
}
