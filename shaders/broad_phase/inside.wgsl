// Whether every body's box still lies inside its stored box, so that the list of candidate pairs is complete; and the
// largest radius of a box.

var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> boxes: array<vec4r>;
var<storage, read> stored_cells: array<vec4<i32>>;
var<storage, read> stored_remainders: array<vec4r>;
var<storage, read> stored_boxes: array<vec4r>;
var<storage, read_write> report: Report;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let box = boxes[i];
    if box.w < 0.0 || !is_finite(box.x + box.y + box.z + box.w) {
        atomicMin(&report.not_finite, i);
        return;
    }
    // All invocations share the report: most boxes are no larger than one before them.
    if bitcast<u32>(f32(box.w)) > atomicLoad(&report.largest) {
        atomicMax(&report.largest, bitcast<u32>(f32(box.w)));
    }
    if parameters.has_list == 0u { return; }
    let moved = lattice_difference(stored_cells[i].xyz, stored_remainders[i].xyz, cells[i].xyz, remainders[i].xyz);
    if !all(abs(moved) + box.xyz <= stored_boxes[i].xyz) && atomicLoad(&report.outside) == 0u {
        atomicMax(&report.outside, 1u);
    }
}
