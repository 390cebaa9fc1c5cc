// Changes the separations of staged contacts from the lengths in the middle of the step to those at its end, like
// stretch.wgsl for pairs.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> grown_shapes: array<vec4r>;
var<storage, read> row_start: array<u32>;
var<storage, read_write> staged: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
        let contact = staged[3u * row];
        var nearer = stretch(pairs[p].x, staged[3u * row + 1u].xyz, contact.xyz);
        // A surface does not change.
        if !is_surface(pairs[p].y) {
            nearer += stretch(pairs[p].y, staged[3u * row + 2u].xyz, -contact.xyz);
        }
        staged[3u * row].w = contact.w - nearer;
    }
}
