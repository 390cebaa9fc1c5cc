// The trial C(U): the total velocity U = U_free + L v / sqrt(dt), and the pose at its end from the step's start.

var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> velocities: array<vec4r>;
var<storage, read_write> motions: array<vec4r>;
var<storage, read_write> trial_cells: array<vec4<i32>>;
var<storage, read_write> trial_remainders: array<vec4r>;
var<storage, read_write> trial_orientations: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    var linear: vec3r;
    var angular: vec3r;
    let first = MOTION * i;
    var free_linear = motions[first].xyz;
    var free_angular = motions[first + 1u].xyz;
    if PLANAR {
        let v = velocities[i];
        linear = vec3r(v.xy, 0.0);
        angular = vec3r(0.0, 0.0, v.z);
        free_linear.z = 0.0;
        free_angular = vec3r(0.0, 0.0, free_angular.z);
    } else {
        linear = velocities[2u * i].xyz;
        angular = velocities[2u * i + 1u].xyz;
    }
    var contact = rotation_root(i, angular) / parameters.root_dt;
    if PLANAR {
        contact = vec3r(0.0, 0.0, contact.z);
    }
    linear = free_linear + motions[first].w / parameters.root_dt * linear;
    angular = free_angular + contact;
    motions[first + 2u] = vec4r(linear, motions[first + 2u].w);
    motions[first + 3u] = vec4r(angular, motions[first + 3u].w);
    let place = lattice_add(cells[i].xyz, remainders[i].xyz, parameters.dt * linear);
    trial_cells[i] = vec4<i32>(place.cell, 0);
    trial_remainders[i] = vec4r(place.remainder, 0.0);
    let turned = orientation_advance(Orientation(orientations[2u * i], orientations[2u * i + 1u]), 0.5 * parameters.dt * angular);
    trial_orientations[2u * i] = turned.coarse;
    trial_orientations[2u * i + 1u] = turned.fine;
}
