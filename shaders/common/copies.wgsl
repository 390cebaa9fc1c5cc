// Writes, copies and clears of an ensemble's members between two dispatches: one workgroup per member, one piece after
// the other.

// The offset of the list in `list`.
@group(0) @binding(0) var<storage, read> places: array<vec4<u32>>;
// For each member the range of its pieces; then the pieces; then the words to write.
@group(0) @binding(1) var<storage, read> list: array<u32>;
@group(0) @binding(2) var<storage, read_write> arena: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let span = places[0].x + 2u * group.x;
    let end = list[span + 1u];
    for (var piece = list[span]; piece < end; piece += 4u) {
        let source = list[piece + 1u];
        let goal = list[piece + 2u];
        let words = list[piece + 3u];
        let kind = list[piece];
        // One loop for all kinds: a driver without branches would run through a loop for each.
        for (var word = local; word < words; word += WORKGROUP) {
            var value = 0u;
            if kind == WRITE { value = list[source + word]; }
            if kind == COPY { value = arena[source + word]; }
            arena[goal + word] = value;
        }
        storageBarrier();
        workgroupBarrier();
    }
}
