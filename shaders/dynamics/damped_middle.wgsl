// The motion over a step with a middle, for bodies with inertia and drag. `motions` holds the mobilities and the
// impulses of half a step of the forces in the middle. Half of the drag and of the impulses comes before the move, and
// half after it: the last vector of a motion is the impulse that is still to come.

var<storage, read> orientations: array<vec4r>;
var<storage, read> twists: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read_write> motions: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let first = MOTION * i;
    let speeding = motions[first];
    let impulse = motions[first + 6u].xyz;
    let moments = moments_of(shapes[i]);
    let q = unit_quaternion(orientations[2u * i], orientations[2u * i + 1u]);
    let momentum = momentum_kept(moments, q, twists[2u * i + 1u].xyz);
    let before = damping(shapes[i], 0.5 * parameters.dt);
    let turning = parts_of(q, before.turn_kept, momentum) + impulse;
    motions[first] = vec4r(before.kept * twists[2u * i].xyz + speeding.xyz, speeding.w);
    motions[first + 1u] = vec4r(turning_of(moments, q, turning, parameters.dt), 0.0);
    motions[first + 6u] = vec4r(turning, 0.0);
    motions[first + 7u] = vec4r(impulse, 0.0);
}
