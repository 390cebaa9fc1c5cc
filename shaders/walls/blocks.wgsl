// The offset of the rows of each pair for a solver. The rows of all places of a body at a surface form one block, that
// of the first place; the blocks of its other places are empty. The places of a body at a surface are consecutive in
// the list, from place zero.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> row_start: array<u32>;
var<storage, read_write> block_start: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p > parameters.pairs { return; }
    var next = p;
    while next < parameters.pairs && is_surface(pairs[next].y) && place_of(pairs[next].y) > 0u {
        next += 1u;
    }
    block_start[p] = row_start[next];
}
