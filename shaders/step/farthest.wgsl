// The largest displacement of a surface point in the step, over all bodies, and that by rotation alone: they determine
// whether any two bodies can have tunnelled. Also the largest displacement of a centre by contact, and the largest
// rotation of a body of revolution by contact about its own axis; in a second pass the first body with this
// displacement.

var<storage, read> shapes: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> motions: array<vec4r>;
var<storage, read_write> report: Report;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let moved = bitcast<u32>(f32(length(contact_move(i))));
    if parameters.pass_number == 2u {
        if moved == atomicLoad(&report.largest_move) { atomicMin(&report.moved, i); }
        return;
    }
    if moved > atomicLoad(&report.largest_move) {
        atomicMax(&report.largest_move, moved);
    }
    if !PLANAR {
        let turned = motions[MOTION * i + 3u].xyz - motions[MOTION * i + 1u].xyz;
        let spun = bitcast<u32>(f32(parameters.dt * abs(dot(axis_of(i), turned))));
        if spun > atomicLoad(&report.axial_spin) {
            atomicMax(&report.axial_spin, spun);
        }
    }
    let radius = bounding_radius(placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]));
    let first = MOTION * i + 2u;
    let turned = parameters.dt * radius * length(motions[first + 1u].xyz);
    let motion = parameters.dt * length(motions[first].xyz) + turned;
    // All invocations share these values: most do not raise the maximum.
    if bitcast<u32>(f32(motion)) > atomicLoad(&report.farthest) {
        atomicMax(&report.farthest, bitcast<u32>(f32(motion)));
    }
    if bitcast<u32>(f32(turned)) > atomicLoad(&report.turned) {
        atomicMax(&report.turned, bitcast<u32>(f32(turned)));
    }
}
