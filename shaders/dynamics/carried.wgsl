// The configuration to which the flow of a changing cell leads bodies in this step, from its start: first rows are
// linearised there, so that they do not depend on the images of bodies. The flow's velocity counts as the velocity that
// led there.

var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read_write> motions: array<vec4r>;
var<storage, read_write> ahead_cells: array<vec4<i32>>;
var<storage, read_write> ahead_remainders: array<vec4r>;
var<storage, read_write> ahead_orientations: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let position = vec3r(cells[i].xyz) * PITCH + remainders[i].xyz;
    var linear = parameters.strain * position;
    if PLANAR { linear.z = 0.0; }
    let first = MOTION * i;
    motions[first + 2u] = vec4r(linear, motions[first + 2u].w);
    motions[first + 3u] = vec4r(0.0, 0.0, 0.0, motions[first + 3u].w);
    let place = lattice_add(cells[i].xyz, remainders[i].xyz, parameters.dt * linear);
    ahead_cells[i] = vec4<i32>(place.cell, 0);
    ahead_remainders[i] = vec4r(place.remainder, 0.0);
    ahead_orientations[2u * i] = orientations[2u * i];
    ahead_orientations[2u * i + 1u] = orientations[2u * i + 1u];
}
