// The velocity J^T x of every body, from the blocks gathered in the order of the bodies' lists.
@group(0) @binding(1) var<storage, read> vectors: array<real>;
@group(0) @binding(2) var<storage, read> incidence_start: array<u32>;
@group(0) @binding(3) var<storage, read> incidence: array<u32>;
@group(0) @binding(4) var<storage, read> gathered: array<vec4r>;
@group(0) @binding(5) var<storage, read_write> velocity: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let step = groups.x * groups.y * WORKGROUP;
    for (var body = invocation(group, groups, local); body < parameters.bodies; body += step) {
        let last = incidence_start[body + 1u];
        var sum = vec4r();
        var turn = vec4r();
        for (var place = incidence_start[body]; place < last; place += 1u) {
            let x = vectors[at(parameters.x, incidence[place] / 2u)];
            sum += x * gathered[place * WIDTH];
            if WIDTH == 2u {
                turn += x * gathered[place * WIDTH + 1u];
            }
        }
        velocity[body * WIDTH] = sum;
        if WIDTH == 2u {
            velocity[body * WIDTH + 1u] = turn;
        }
    }
}
