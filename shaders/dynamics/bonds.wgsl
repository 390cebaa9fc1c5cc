// Adds the loads of bonds to those of each body: k (1 - l / |way|) way at the first point, the opposite
// at the other. Bonds are summed in the order of their indices.

var<storage, read> broken: array<u32>;
// For each body the offset of its entries, then the end of the last ones; then the entries: twice a bond's number, plus
// one at its second body.
var<storage, read> incident: array<u32>;
var<storage, read_write> loads: array<vec4r>;

fn pull_of(bond: u32, way: vec3r) -> vec3r {
    let stiffness = bonds[2u * bond].w;
    let rest = bonds[2u * bond + 1u].w;
    if rest == 0.0 { return stiffness * way; }
    let distance = length(way);
    // Both points coincide: a bond of positive length has no direction.
    if distance == 0.0 { return vec3r(); }
    return stiffness * (1.0 - rest / distance) * way;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    var force = vec3r();
    var torque = vec3r();
    for (var at = incident[i]; at < incident[i + 1u]; at += 1u) {
        let bond = incident[at] / 2u;
        if broken[bond] > 0u { continue; }
        let end = incident[at] % 2u;
        let pull = pull_of(bond, way_of(bond));
        let own = select(pull, -pull, end == 1u);
        force += own;
        torque += cross(arm_of(bonds[2u * bond + end].xyz, i), own);
    }
    if PLANAR {
        force.z = 0.0;
        torque = vec3r(0.0, 0.0, torque.z);
    }
    if parameters.adds > 0u {
        force += loads[2u * i].xyz;
        torque += loads[2u * i + 1u].xyz;
    }
    loads[2u * i] = vec4r(force, 0.0);
    loads[2u * i + 1u] = vec4r(torque, 0.0);
}
