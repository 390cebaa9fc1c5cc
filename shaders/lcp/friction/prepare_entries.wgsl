// The blocks of J in the order of the bodies' lists, so that the pass over the bodies reads them one after the other.
var<storage, read> incidence_start: array<u32>;
var<storage, read> incidence: array<u32>;
var<storage, read> jacobian: array<vec4r>;
var<storage, read> tangents: array<vec4r>;
var<storage, read_write> gathered: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let place = invocation(group, groups, local);
    // Bodies without mobility are in no list.
    if place >= incidence_start[parameters.bodies] { return; }
    for (var line = 0u; line < ROWS; line += 1u) {
        let to = (place * ROWS + line) * WIDTH;
        for (var k = 0u; k < WIDTH; k += 1u) {
            gathered[to + k] = given_block(incidence[place] / 2u, line, incidence[place] % 2u, k);
        }
    }
}
