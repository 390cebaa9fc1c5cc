// The boxes of a search: those of the bodies, widened by the skin.

// The skin, a length.
var<storage, read> skin: array<real>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> boxes: array<vec4r>;
var<storage, read_write> stored_cells: array<vec4<i32>>;
var<storage, read_write> stored_remainders: array<vec4r>;
var<storage, read_write> stored_boxes: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    stored_cells[i] = cells[i];
    stored_remainders[i] = remainders[i];
    stored_boxes[i] = boxes[i] + vec4r(skin[0]);
}
