// The index of each pair of a new list in the old list, or NONE. The search covers the old pairs of the body with fewer
// pairs, or of the first body if the second is a surface.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> old_pairs: array<vec2<u32>>;
var<storage, read> old_start: array<u32>;
var<storage, read> old_adjacency: array<u32>;
var<storage, read_write> old_pair: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    let pair = pairs[p];
    var found = NONE;
    let at_surface = is_surface(pair.y);
    if pair.x < parameters.old_bodies && (at_surface || pair.y < parameters.old_bodies) {
        var body = pair.x;
        if !at_surface && old_start[pair.y + 1u] - old_start[pair.y] < old_start[pair.x + 1u] - old_start[pair.x] {
            body = pair.y;
        }
        for (var k = old_start[body]; k < old_start[body + 1u]; k += 1u) {
            let candidate = adjacency_pair(old_adjacency[k]);
            if all(old_pairs[candidate] == pair) {
                found = candidate;
                break;
            }
        }
    }
    old_pair[p] = found;
}

fn adjacency_pair(entry: u32) -> u32 {
    return entry >> 1u;
}
