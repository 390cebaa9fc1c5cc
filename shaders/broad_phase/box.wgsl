// The box of each body at the step's start, or in its middle. It is widened by half the cutoff and by the rest of the
// body's own free motion in the step. The fourth number bounds the box at every orientation.

var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> motions: array<vec4r>;
var<storage, read_write> boxes: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    let body = placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]);
    let radius = bounding_radius(body);
    let first = MOTION * i;
    let linear = motions[first].xyz - motions[first + 2u].xyz;
    let angular = motions[first + 1u].xyz - motions[first + 3u].xyz;
    let reach = parameters.dt * (length(linear) + length(angular) * radius);
    let margin = 0.5 * CUTOFF + reach;
    boxes[i] = vec4r(half_extents(body) + vec3r(margin), radius + margin);
}
