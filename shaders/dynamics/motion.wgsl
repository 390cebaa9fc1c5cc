// Forces, free velocity and effective mobility of each body at the step's start, or in its middle. The scene defines
// `law`, `load_of` and the parameters, which have the share of each window of its forces.
//
// A body's motion is MOTION vectors: (free velocity, root of the translational mobility), (free angular velocity, root
// of the rotational mobility), the velocity and the angular velocity of the present trial (none
// here; bodies came to the middle of a step with half of the first half's velocity over the whole step), in space each
// followed by a number of the body's axis where forces act (axis.wgsl), and with inertia the six numbers of the
// rotational root and the angular momentum at the step's end.

var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> twists: array<vec4r>;
var<storage, read> groups_of: array<u32>;
var<storage, read> loads: array<vec4r>;
var<storage, read_write> motions: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let position = vec3r(cells[i].xyz) * PITCH + remainders[i].xyz;
    let shape = shapes[i];
    let q = unit_quaternion(orientations[2u * i], orientations[2u * i + 1u]);
    var load = load_of(position, q, shape, groups_of[i]);
    if PLUGGED {
        load.force += loads[2u * i].xyz;
        load.torque += loads[2u * i + 1u].xyz;
    }
    let first = MOTION * i;
    let motion = law(shape, q, load, twists[2u * i].xyz, twists[2u * i + 1u].xyz);
    motions[first] = vec4r(motion.linear, motion.translation);
    motions[first + 1u] = vec4r(motion.angular, motion.rotation);
    var axis = vec2r();
    if !PLANAR {
        axis = axis_numbers(rotate(q, axis_of_revolution(shape)));
    }
    if parameters.in_middle > 0u {
        motions[first + 2u] = vec4r(0.5 * motions[first + 2u].xyz, axis.x);
        motions[first + 3u] = vec4r(0.5 * motions[first + 3u].xyz, axis.y);
    } else {
        motions[first + 2u] = vec4r(0.0, 0.0, 0.0, axis.x);
        motions[first + 3u] = vec4r(0.0, 0.0, 0.0, axis.y);
    }
    if MOTION > 4u {
        motions[first + 4u] = vec4r(motion.root[0].xyz, motion.root[1].y);
        motions[first + 5u] = vec4r(motion.root[1].z, motion.root[2].z, 0.0, 0.0);
        motions[first + 6u] = vec4r(motion.momentum, 0.0);
    }
}
