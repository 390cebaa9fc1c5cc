// The largest distance of any body's start outside its stored box. With the motion of its surface in the step it bounds
// the overlap on the path of two bodies that are not a candidate pair.

struct Parameters { bodies: u32, a: u32, b: u32, c: u32 }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> cells: array<vec4<i32>>;
@group(0) @binding(2) var<storage, read> remainders: array<vec4r>;
@group(0) @binding(3) var<storage, read> orientations: array<vec4r>;
@group(0) @binding(4) var<storage, read> shapes: array<vec4r>;
@group(0) @binding(5) var<storage, read> stored_cells: array<vec4<i32>>;
@group(0) @binding(6) var<storage, read> stored_remainders: array<vec4r>;
@group(0) @binding(7) var<storage, read> stored_boxes: array<vec4r>;
@group(0) @binding(8) var<storage, read_write> report: Report;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let off = lattice_difference(stored_cells[i].xyz, stored_remainders[i].xyz, cells[i].xyz, remainders[i].xyz);
    let body = placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]);
    let outside = abs(off) + half_extents(body) - stored_boxes[i].xyz;
    let most = max(outside.x, max(outside.y, outside.z));
    if !(most <= 0.0) && bitcast<u32>(f32(most)) > atomicLoad(&report.strayed) {
        atomicMax(&report.strayed, bitcast<u32>(f32(most)));
    }
}
