// The largest distance of any body's start outside its stored box. With the motion of its surface in the step it bounds
// the overlap on the path of two bodies that are not a candidate pair.

var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
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
    let off = lattice_difference(stored_cells[i].xyz, stored_remainders[i].xyz, cells[i].xyz, remainders[i].xyz);
    let body = placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]);
    let outside = abs(off) + half_extents(body) - stored_boxes[i].xyz;
    let most = max(outside.x, max(outside.y, outside.z));
    if !(most <= 0.0) && bitcast<u32>(f32(most)) > atomicLoad(&report.strayed) {
        atomicMax(&report.strayed, bitcast<u32>(f32(most)));
    }
}
