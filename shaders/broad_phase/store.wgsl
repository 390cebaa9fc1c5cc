// The boxes of a search: those of the bodies, widened by the skin.

struct Parameters { bodies: u32, a: u32, b: u32, c: u32 }

// The skin, a length.
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> skin: array<real>;
@group(0) @binding(2) var<storage, read> cells: array<vec4<i32>>;
@group(0) @binding(3) var<storage, read> remainders: array<vec4r>;
@group(0) @binding(4) var<storage, read> boxes: array<vec4r>;
@group(0) @binding(5) var<storage, read_write> stored_cells: array<vec4<i32>>;
@group(0) @binding(6) var<storage, read_write> stored_remainders: array<vec4r>;
@group(0) @binding(7) var<storage, read_write> stored_boxes: array<vec4r>;

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
