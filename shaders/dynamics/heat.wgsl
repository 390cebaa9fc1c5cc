// The random loads of Brownian motion (src/dynamics/thermal.rs has the equations), added to those of the host. The
// scene defines `strength`.

var<storage, read> ids: array<vec2<u32>>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read_write> loads: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let key = vec2<u32>(SEED_LOW, SEED_HIGH);
    let counter = vec4<u32>(ids[i], parameters.step_low, parameters.step_high);
    let first = philox(counter, key);
    let second = philox(counter ^ vec4<u32>(0u, 0u, 0u, 1u << BLOCK_SHIFT), key);
    let a = normal_pair(first.x, first.y);
    let b = normal_pair(first.z, first.w);
    let c = normal_pair(second.x, second.y);
    let strong = strength(shapes[i], parameters.dt);
    let q = unit_quaternion(orientations[2u * i], orientations[2u * i + 1u]);
    var force = vec4r(strong.x * vec3r(a, b.x), 0.0);
    var torque = vec4r(rotate(q, strong.yzw * vec3r(b.y, c)), 0.0);
    if PLANAR {
        force.z = 0.0;
        torque = vec4r(0.0, 0.0, torque.z, 0.0);
    }
    if parameters.adds > 0u {
        force += loads[2u * i];
        torque += loads[2u * i + 1u];
    }
    loads[2u * i] = force;
    loads[2u * i + 1u] = torque;
}
