// The velocities of an accepted step.

var<storage, read> motions: array<vec4r>;
var<storage, read_write> twists: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    twists[2u * i] = vec4r(motions[MOTION * i + 2u].xyz, 0.0);
    twists[2u * i + 1u] = vec4r(motions[MOTION * i + 3u].xyz, 0.0);
}
