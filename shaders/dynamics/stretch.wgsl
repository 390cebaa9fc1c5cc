// Changes the separations of near pairs from the lengths in the middle of the step to the lengths at its end: as a body
// grows, its surface moves along the normal at the contact. The separation is an extremum over the axis, so this is its
// derivative with respect to the length.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> grown_shapes: array<vec4r>;
var<storage, read_write> contacts: array<vec4r>;

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
