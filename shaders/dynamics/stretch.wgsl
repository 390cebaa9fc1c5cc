// Changes the separations of near pairs from the lengths in the middle of the step to the lengths at its end: as a body
// grows, its surface moves along the normal at the contact. The separation is an extremum over the axis, so this is its
// derivative with respect to the length.

struct Parameters { pairs: u32, a: u32, b: u32, c: u32 }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> orientations: array<vec4r>;
@group(0) @binding(3) var<storage, read> shapes: array<vec4r>;
@group(0) @binding(4) var<storage, read> grown: array<vec4r>;
@group(0) @binding(5) var<storage, read_write> contacts: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs || contacts[3u * p + 2u].w == 0.0 { return; }
    let contact = contacts[3u * p];
    var nearer = stretch(pairs[p].x, contacts[3u * p + 1u].xyz, contact.xyz);
    // A surface does not change.
    if !is_surface(pairs[p].y) {
        nearer += stretch(pairs[p].y, contacts[3u * p + 2u].xyz, -contact.xyz);
    }
    contacts[3u * p].w = contact.w - nearer;
}
