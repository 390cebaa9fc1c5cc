// One body's share of g, and of the products that compare the directions of the row's block and of the overlap's block:
// of the first with itself, of both, and of the second with itself.
struct Share { g: real, own: real, both: real, there: real }

fn share(row: u32, side: u32, body: u32, normal: vec3r, lever: vec3r) -> Share {
    let there = part(body, normal, lever);
    if PLANAR {
        let block = jacobian[2u * row + side].xyz;
        let other = vec3r(there.linear.xy, there.angular.z);
        return Share(dot(block, velocities[body].xyz), dot(block, block), dot(block, other), dot(other, other));
    }
    let linear = jacobian[4u * row + 2u * side].xyz;
    let angular = jacobian[4u * row + 2u * side + 1u].xyz;
    return Share(
        dot(linear, velocities[2u * body].xyz) + dot(angular, velocities[2u * body + 1u].xyz),
        dot(linear, linear) + dot(angular, angular),
        dot(linear, there.linear) + dot(angular, there.angular),
        dot(there.linear, there.linear) + dot(there.angular, there.angular),
    );
}
