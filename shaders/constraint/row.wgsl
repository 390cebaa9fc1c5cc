// Makes one row: the affine inequality in the step's total velocity U
//
//     g(U) = Phi(C_j) + dt D . (U - U_j) >= 0,   D = (-n, -t_a, n, t_b),
//
// with the torque arms carried back through the quaternion update, t -> (t - h x t) / (1 + |h|^2), h = dt w_j / 2, and
// each block scaled by the root of its body's effective mobility, J = sqrt(dt) D L.
//
// The kernel has the arrays of rows, and `parameters` the number of bodies.

// The row of a contact, (normal, separation), with the levers of both bodies.
fn append(row: u32, pair: vec2<u32>, contact: vec4r, lever_a: vec3r, lever_b: vec3r) {
    let a = part(pair.x, -contact.xyz, lever_a);
    // A surface does not move: its block is zero. In rows surfaces come after all bodies.
    var second = pair.y;
    var b = Part(vec3r(), vec3r(), real(0.0));
    if is_surface(second) {
        second = parameters.bodies + surface_of(second);
    } else {
        b = part(second, contact.xyz, lever_b);
    }
    row_pairs[row] = vec2<u32>(pair.x, second);
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
}
