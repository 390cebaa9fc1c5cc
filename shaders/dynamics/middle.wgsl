// The motion of a whole step whose forces and mobilities are those of its middle. `motions` holds the law's motion there over the whole step, from
// the velocity that the first half ended with.
//
// Bodies came to the middle with half of that velocity over the whole step. With inertia half of the forces' impulse comes after the move:
// U_free = U^k + (U_law - U_h) / 2.

struct Parameters { bodies: u32, a: u32, b: u32, c: u32 }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> start_twists: array<vec4r>;
@group(0) @binding(2) var<storage, read> twists: array<vec4r>;
@group(0) @binding(3) var<storage, read_write> motions: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let first = MOTION * i;
    let linear = twists[2u * i].xyz;
    let angular = twists[2u * i + 1u].xyz;
    if INERTIA {
        let free = motions[first];
        let turning = motions[first + 1u];
        motions[first] = vec4r(start_twists[2u * i].xyz + 0.5 * (free.xyz - linear), free.w);
        motions[first + 1u] = vec4r(start_twists[2u * i + 1u].xyz + 0.5 * (turning.xyz - angular), turning.w);
    }
    motions[first + 2u] = vec4r(0.5 * linear, 0.0);
    motions[first + 3u] = vec4r(0.5 * angular, 0.0);
}
