// Sets the radii of every growing ellipsoid to those at its length, with the radii of curvature of its tips.

// Of each body, along x and y; zero for bodies that are not growing ellipsoids.
var<storage, read> tips: array<vec2r>;
var<storage, read> lengths: array<vec2r>;
var<storage, read_write> shapes: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies || tips[i].x == 0.0 { return; }
    let half = 0.5 * (lengths[i].x + lengths[i].y);
    shapes[i] = vec4r(sqrt(half * tips[i]), half, shapes[i].w);
}
