// Marks pairs of bodies that a bond keeps from colliding as far: they have no row and no overlap.

var<storage, read> pairs: array<vec2<u32>>;
// Such pairs, the smaller index first, ascending.
var<storage, read> parted: array<vec2<u32>>;
var<storage, read_write> contacts: array<vec4r>;

fn precedes(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    let pair = pairs[p];
    var first = 0u;
    var end = parameters.count;
    while first < end {
        let middle = (first + end) / 2u;
        if precedes(parted[middle], pair) {
            first = middle + 1u;
        } else {
            end = middle;
        }
    }
    if first < parameters.count && all(parted[first] == pair) { contacts[3u * p + 2u].w = FAR; }
}
