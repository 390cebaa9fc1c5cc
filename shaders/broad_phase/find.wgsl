// The pairs that every body finds: first counted, then written by the same code. A body searches those cells of its own
// level that come after its own cell, in the order z, y, x, and all cells of the coarser levels that it can touch.
// In the order of columns; the last word is body and level.
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> boxes: array<vec4r>;
// The start of every column.
var<storage, read> starts: array<u32>;
var<storage, read> survey: array<u32>;
// For each body: the number of pairs that it found, or the offset at which they are written.
var<storage, read_write> list: array<u32>;
var<storage, read_write> pairs: array<vec2<u32>>;
// Faults, and the number of pairs that crowded bodies found.
var<storage, read_write> crowds: array<atomic<u32>, 2>;

// Whether the box of the `q`th body touches this one. The slack exceeds all rounding errors of this test and of the
// earlier conversion to `real`.
fn touches(cell: vec3<i32>, remainder: vec3r, half: vec3r, q: u32) -> bool {
    let apart = abs(lattice_difference(cell, remainder, cells[q].xyz, remainders[q].xyz));
    let reach = (half + boxes[q].xyz) * (1.0 + 4.0 * EPSILON) + 2.0 * EPSILON * PITCH;
    return apart.x <= reach.x && apart.y <= reach.y && (PLANAR == 1u || apart.z <= reach.z);
}

fn level_reach(level: u32) -> vec3<u32> {
    var reach = vec3<u32>(0u);
    for (var axis = 0u; axis < 3u; axis += 1u) {
        let word = REACH + 3u * level + axis;
        reach[axis] = max(survey[word], survey[word - 3u]);
    }
    return reach;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.bodies { return; }
    let cell = cells[p].xyz;
    let remainder = remainders[p].xyz;
    var half = boxes[p].xyz;
    if PLANAR == 1u { half.z = 0.0; }
    let body = bitcast<u32>(cells[p].w) & BODY_MASK;
    let level = bitcast<u32>(cells[p].w) >> LEVEL_SHIFT;
    var found = 0u;
    var to = 0u;
    if parameters.fill == 1u { to = list[body]; }
    var rounds = 0u;
    var rest = 0u;
    if level > 0u { rest = survey[CLASSES]; }
    while rest != 0u {
        let other_level = firstLeadingBit(rest);
        if other_level < level { break; }
        rest = finer(rest, other_level);
        // Boxes that reach over 2^30 lattice cells are of level 31, where two grid cells are everything.
        let span = vec3<i32>(min(lattice_reach(half) + level_reach(other_level), vec3<u32>(1073741824u)));
        let low = grid_cell(cell - span, other_level);
        let high = grid_cell(cell + span, other_level);
        let own = grid_cell(cell, other_level);
        let same = other_level == level;
        for (var z = select(low.z, own.z, same); z <= high.z; z += 1) {
            let same_layer = same && z == own.z;
            for (var y = select(low.y, own.y, same_layer); y <= high.y; y += 1) {
                let same_row = same_layer && y == own.y;
                let from_x = select(low.x, own.x, same_row);
                let base = row(other_level, y, z);
                let first = (base + bitcast<u32>(from_x)) & parameters.mask;
                let last = (base + bitcast<u32>(high.x)) & parameters.mask;
                // If the row crosses the table's end, its other part is at the beginning.
                let parts = select(1u, 2u, first > last);
                for (var part = 0u; part < parts; part += 1u) {
                    let begin = select(starts[first], 0u, part == 1u);
                    let end = select(starts[last + 1u], parameters.bodies, part + 1u < parts);
                    rounds += end - begin + 1u;
                    if rounds > MOST_ROUNDS { break; }
                    for (var q = begin; q < end; q += 1u) {
                        let word = bitcast<u32>(cells[q].w);
                        let cell_of_other = grid_cell(cells[q].xyz, other_level);
                        // Other levels and cells may share the columns.
                        if word >> LEVEL_SHIFT != other_level || cell_of_other.y != y || cell_of_other.z != z { continue; }
                        if same_row && cell_of_other.x == own.x && q <= p { continue; }
                        if !touches(cell, remainder, half, q) { continue; }
                        if parameters.fill == 1u {
                            let other = word & BODY_MASK;
                            pairs[to + found] = vec2<u32>(min(body, other), max(body, other));
                        }
                        found += 1u;
                    }
                }
                if rounds > MOST_ROUNDS { break; }
            }
            if rounds > MOST_ROUNDS { break; }
        }
        if rounds > MOST_ROUNDS {
            atomicOr(&crowds[0], CROWDED);
            break;
        }
    }
    if parameters.fill == 1u { return; }
    list[body] = found;
    // Bodies with fewer than `large` pairs have fewer than 2^31 together. The others must too, or the sum overflows a
    // word.
    if found >= parameters.large && atomicAdd(&crowds[1], found) >= 0x80000000u - found { atomicOr(&crowds[0], TOO_MANY); }
}
