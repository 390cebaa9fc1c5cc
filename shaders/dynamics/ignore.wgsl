// Marks pairs without mobility, two fixed bodies or one and a wall, as far: they have no row and no overlap.

var<storage, read> pairs: array<vec2<u32>>;
// For the first bodies: whether they are fixed. All later bodies move.
var<storage, read> is_fixed: array<u32>;
var<storage, read_write> contacts: array<vec4r>;

fn is_held(body: u32) -> bool {
    return body < parameters.flagged && is_fixed[body] != 0u;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    if is_held(pairs[p].x) && (is_surface(pairs[p].y) || is_held(pairs[p].y)) {
        contacts[3u * p + 2u].w = FAR;
    }
}
