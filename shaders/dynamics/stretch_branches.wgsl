// Changes the separations of staged contacts from the lengths in the middle of the step to those at its end, like
// stretch.wgsl for pairs.

struct Parameters { pairs: u32, a: u32, b: u32, c: u32 }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> orientations: array<vec4r>;
@group(0) @binding(3) var<storage, read> shapes: array<vec4r>;
@group(0) @binding(4) var<storage, read> grown: array<vec4r>;
@group(0) @binding(5) var<storage, read> row_start: array<u32>;
@group(0) @binding(6) var<storage, read_write> staged: array<vec4r>;

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
