// Makes the last row of every pair whose flag is at least the threshold: the affine inequality in the step's total velocity U
//
//     g(U) = Phi(C_j) + dt D . (U - U_j) >= 0,   D = (-n, -t_a, n, t_b),
//
// with the torque arms carried back through the quaternion update, t -> (t - h x t) / (1 + |h|^2), h = dt w_j / 2, and each block scaled by the
// root of its body's effective mobility, J = sqrt(dt) D L.

struct Parameters { pairs: u32, threshold: u32, warm: u32, bodies: u32, dt: real, root_dt: real }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> row_start: array<u32>;
@group(0) @binding(3) var<storage, read> contacts: array<vec4r>;
@group(0) @binding(4) var<storage, read> motions: array<vec4r>;
@group(0) @binding(5) var<storage, read_write> row_pairs: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> jacobian: array<vec4r>;
@group(0) @binding(7) var<storage, read_write> q: array<real>;
@group(0) @binding(8) var<storage, read_write> gamma: array<real>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs || u32(contacts[3u * p + 2u].w) < parameters.threshold { return; }
    let row = row_start[p + 1u] - 1u;
    let contact = contacts[3u * p];
    let a = part(pairs[p].x, -contact.xyz, contacts[3u * p + 1u].xyz);
    // A surface does not move: its block is zero. In rows surfaces come after all bodies.
    var second = pairs[p].y;
    var b = Part(vec3r(), vec3r(), real(0.0));
    if is_surface(second) {
        second = parameters.bodies + surface_of(second);
    } else {
        b = part(second, contact.xyz, contacts[3u * p + 2u].xyz);
    }
    row_pairs[row] = vec2<u32>(pairs[p].x, second);
    if PLANAR {
        jacobian[2u * row] = vec4r(a.linear.xy, a.angular.z, 0.0);
        jacobian[2u * row + 1u] = vec4r(b.linear.xy, b.angular.z, 0.0);
    } else {
        jacobian[4u * row] = vec4r(a.linear, 0.0);
        jacobian[4u * row + 1u] = vec4r(a.angular, 0.0);
        jacobian[4u * row + 2u] = vec4r(b.linear, 0.0);
        jacobian[4u * row + 3u] = vec4r(b.angular, 0.0);
    }
    q[row] = contact.w + (a.still_to_come + b.still_to_come);
    gamma[row] = select(real(0.0), contacts[3u * p + 1u].w, parameters.warm != 0u);
}
