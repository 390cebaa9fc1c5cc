// Sets every growing body's length to that at the end of the step. The length has a coarse and a fine part, like
// orientations, so that thousands of small increments accumulate.

var<storage, read_write> shapes: array<vec4r>;
var<storage, read_write> lengths: array<vec2r>;
// The relative growth of each body in a step.
var<storage, read> growths: array<real>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies || !grows(shapes[i]) { return; }
    let before = lengths[i];
    let fine = before.y + (before.x + before.y) * growths[i];
    let whole = floor(fine / LENGTH_PITCH + 0.5);
    let after = vec2r(before.x + whole * LENGTH_PITCH, fine - whole * LENGTH_PITCH);
    lengths[i] = after;
    shapes[i] = with_length(shapes[i], after.x + after.y);
}
