// Moves the offset of the first row of each pair that violates, so that the row is exact at the trial:
//
//     q += Phi(C(U)) - g(U),   g(U) = q + J v,
//
// if that row was made from the pair's near surfaces, has the direction of the overlap, and becomes tighter. Such a pair is near then and no longer
// violating: the others get a row.

struct Parameters { pairs: u32, bodies: u32, b: u32, c: u32 }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> row_start: array<u32>;
@group(0) @binding(2) var<storage, read> is_first: array<real>;
@group(0) @binding(3) var<storage, read> row_pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> jacobian: array<vec4r>;
@group(0) @binding(5) var<storage, read> velocities: array<vec4r>;
@group(0) @binding(6) var<storage, read_write> q: array<real>;
@group(0) @binding(7) var<storage, read_write> contacts: array<vec4r>;

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
    let a = row_pairs[row].x;
    let b = row_pairs[row].y;
    // A surface's block is zero and has no direction.
    if b >= parameters.bodies { return; }
    var along: vec3r;
    var g = q[row];
    if PLANAR {
        along = vec3r(jacobian[2u * row + 1u].xy, 0.0);
        g += dot(jacobian[2u * row].xyz, velocities[a].xyz) + dot(jacobian[2u * row + 1u].xyz, velocities[b].xyz);
    } else {
        along = jacobian[4u * row + 2u].xyz;
        g += dot(jacobian[4u * row].xyz, velocities[2u * a].xyz) + dot(jacobian[4u * row + 1u].xyz, velocities[2u * a + 1u].xyz);
        g += dot(along, velocities[2u * b].xyz) + dot(jacobian[4u * row + 3u].xyz, velocities[2u * b + 1u].xyz);
    }
    let contact = contacts[3u * p];
    if dot(along, contact.xyz) > LEAST_ALIGNED * length(along) && contact.w < g {
        q[row] += contact.w - g;
        contacts[3u * p + 2u].w = NEAR;
    }
}
