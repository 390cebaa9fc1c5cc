// Bodies that do not move: their free velocity and their mobility are zero.

var<storage, read> is_fixed: array<u32>;
var<storage, read_write> motions: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies || is_fixed[i] == 0u { return; }
    for (var k = 0u; k < MOTION; k += 1u) {
        motions[MOTION * i + k] = vec4r();
    }
}
