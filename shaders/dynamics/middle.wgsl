// The motion over a step with a middle, for bodies with inertia. `motions` holds the mobilities and the impulses of the
// forces in the middle.
//
// Half of the impulses comes before the move and half after it: u_free = u + dt F / 2 m, w_free is the mean angular
// velocity of a free rotation from L + dt T / 2.

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
    motions[first] = vec4r(twists[2u * i].xyz + 0.5 * speeding.xyz, speeding.w);
    motions[first + 1u] = vec4r(turning_of(moments, q, momentum + 0.5 * impulse, parameters.dt), 0.0);
    motions[first + 6u] = vec4r(momentum + impulse, 0.0);
}
