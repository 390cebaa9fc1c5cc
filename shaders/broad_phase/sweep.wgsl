// Widens each body's box, about its position at the step's start or in its middle, so that it also contains the body at
// the trial. A negative radius marks a box that is not finite.

var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> trial_cells: array<vec4<i32>>;
var<storage, read> trial_remainders: array<vec4r>;
var<storage, read> trial_orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read_write> boxes: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let moved = lattice_difference(cells[i].xyz, remainders[i].xyz, trial_cells[i].xyz, trial_remainders[i].xyz);
    let body = placed(shapes[i], trial_orientations[2u * i], trial_orientations[2u * i + 1u]);
    let reached = abs(moved) + half_extents(body);
    let radius = length(moved) + bounding_radius(body);
    let box = boxes[i];
    if is_finite(reached.x + reached.y + reached.z + radius) && is_finite(trial_remainders[i].x + trial_remainders[i].y + trial_remainders[i].z) {
        boxes[i] = max(box, vec4r(reached, radius));
    } else {
        boxes[i] = vec4r(box.xyz, -1.0);
    }
}
