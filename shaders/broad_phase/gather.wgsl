// Copies the boxes into the order of their columns.
struct Parameters { bodies: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> members: array<u32>;
@group(0) @binding(2) var<storage, read> cells: array<vec4<i32>>;
@group(0) @binding(3) var<storage, read> remainders: array<vec4r>;
@group(0) @binding(4) var<storage, read> boxes: array<vec4r>;
@group(0) @binding(5) var<storage, read_write> sorted_cells: array<vec4<i32>>;
@group(0) @binding(6) var<storage, read_write> sorted_remainders: array<vec4r>;
@group(0) @binding(7) var<storage, read_write> sorted_boxes: array<vec4r>;

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
