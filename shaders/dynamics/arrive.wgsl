// The velocities that a whole step with a middle ends with, where bodies have inertia: the other half of the forces' impulse, U + (U_free - U^k).
// They are already those that the bodies moved with.

struct Parameters { bodies: u32, a: u32, b: u32, c: u32 }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> motions: array<vec4r>;
@group(0) @binding(2) var<storage, read> start_twists: array<vec4r>;
@group(0) @binding(3) var<storage, read_write> twists: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let first = MOTION * i;
    var linear = motions[first].xyz - start_twists[2u * i].xyz;
    var angular = motions[first + 1u].xyz - start_twists[2u * i + 1u].xyz;
    if PLANAR {
        linear.z = 0.0;
        angular = vec3r(0.0, 0.0, angular.z);
    }
    twists[2u * i] = vec4r(twists[2u * i].xyz + linear, 0.0);
    twists[2u * i + 1u] = vec4r(twists[2u * i + 1u].xyz + angular, 0.0);
}
