// Copies the boxes into the order of their columns.
var<storage, read> members: array<u32>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> boxes: array<vec4r>;
var<storage, read_write> sorted_cells: array<vec4<i32>>;
var<storage, read_write> sorted_remainders: array<vec4r>;
var<storage, read_write> sorted_boxes: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.bodies { return; }
    let i = members[p] & BODY_MASK;
    sorted_cells[p] = vec4<i32>(cells[i].xyz, bitcast<i32>(members[p]));
    sorted_remainders[p] = remainders[i];
    sorted_boxes[p] = boxes[i];
}
