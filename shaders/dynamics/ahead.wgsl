// The configuration to which the velocities of the last step lead in the part AHEAD of this one, from its start: first
// rows are linearised there. That part of the velocity counts as the velocity that led there.

var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> twists: array<vec4r>;
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
    let linear = AHEAD * twists[2u * i].xyz;
    let angular = AHEAD * twists[2u * i + 1u].xyz;
    let first = MOTION * i;
    motions[first + 2u] = vec4r(linear, motions[first + 2u].w);
    motions[first + 3u] = vec4r(angular, motions[first + 3u].w);
    let place = lattice_add(cells[i].xyz, remainders[i].xyz, parameters.dt * linear);
    ahead_cells[i] = vec4<i32>(place.cell, 0);
    ahead_remainders[i] = vec4r(place.remainder, 0.0);
    let turned = orientation_advance(Orientation(orientations[2u * i], orientations[2u * i + 1u]), 0.5 * parameters.dt * angular);
    ahead_orientations[2u * i] = turned.coarse;
    ahead_orientations[2u * i + 1u] = turned.fine;
}
