// The velocities at the end of a part of a step, for bodies with inertia and drag. The part's move has these
// velocities. After a whole step with a middle the other half of the drag and of the forces' impulse follows, about the
// axes of the attitude that the step ends with. Rotations conserve the angular momentum in space, including the
// contacts' share.

var<storage, read> motions: array<vec4r>;
var<storage, read> start_twists: array<vec4r>;
// Where mobilities were taken, and where the part ends.
var<storage, read> here_orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> end_orientations: array<vec4r>;
var<storage, read_write> end_twists: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let first = MOTION * i;
    var linear = motions[first + 2u].xyz;
    let after = damping(shapes[i], 0.5 * parameters.dt);
    if parameters.by_middle > 0u {
        linear = after.kept * linear + (motions[first].xyz - after.kept * start_twists[2u * i].xyz);
    }
    let moments = moments_of(shapes[i]);
    let here = unit_quaternion(here_orientations[2u * i], here_orientations[2u * i + 1u]);
    var free = motions[first + 1u].xyz;
    if PLANAR {
        free = vec3r(0.0, 0.0, free.z);
    }
    let by_contact = momentum_of(moments, here, motions[first + 3u].xyz - free);
    let end = unit_quaternion(end_orientations[2u * i], end_orientations[2u * i + 1u]);
    var momentum = motions[first + 6u].xyz + by_contact;
    if parameters.by_middle > 0u {
        momentum = parts_of(end, after.turn_kept, momentum) + motions[first + 7u].xyz;
    }
    var angular = kept_of(moments, end, momentum);
    if PLANAR {
        linear.z = 0.0;
        angular = vec3r(0.0, 0.0, angular.z);
    }
    end_twists[2u * i] = vec4r(linear, 0.0);
    end_twists[2u * i + 1u] = vec4r(angular, 0.0);
}
