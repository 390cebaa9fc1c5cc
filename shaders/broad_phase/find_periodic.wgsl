// As find.wgsl, in periodic space: the cells that a body searches wrap around, each is searched once, and the body with
// the lower number finds a pair of one level.
// Wrapped into one cell of space, in the order of columns; the last word is body and level.
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> boxes: array<vec4r>;
var<storage, read> starts: array<u32>;
var<storage, read> survey: array<u32>;
var<storage, read_write> list: array<u32>;
var<storage, read_write> pairs: array<vec2<u32>>;
var<storage, read_write> crowds: array<atomic<u32>, 2>;

// Additional lattice cells of a search: for two remainders of two and a half pitches, and a fractional period.
const WRAPPED_SLACK: u32 = 6u;

// Grid cells along the axes: `count` of them from `start` on; after `last` follows zero.
struct Around { start: vec3<i32>, count: vec3<i32>, last: vec3<i32> }

// Whether the box of the `q`th body touches this one, through the nearest image: no other image is nearer along any
// axis. The slack exceeds all rounding errors of this test, of wrapping, and of the earlier conversion to `real`.
fn touches(cell: vec3<i32>, remainder: vec3r, half: vec3r, q: u32) -> bool {
    let apart = abs(lattice_difference(cell, remainder, cells[q].xyz, remainders[q].xyz));
    let reach = (half + boxes[q].xyz) * (1.0 + 4.0 * EPSILON) + 16.0 * EPSILON * PITCH;
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

// The grid cells within `span` lattice cells of one; all cells if these cover a whole period.
fn around(cell: vec3<i32>, span: vec3<i32>, level: u32) -> Around {
    let periodic = PERIOD_CELLS > vec3<i32>(0);
    let whole = periodic & (span >= PERIOD_CELLS / 2);
    let before = periodic & (cell - span < vec3<i32>(0));
    let after = periodic & (cell + span >= PERIOD_CELLS);
    let low = grid_cell(cell - span + select(vec3<i32>(0), PERIOD_CELLS, before), level);
    let high = grid_cell(cell + span - select(vec3<i32>(0), PERIOD_CELLS, after), level);
    let end = grid_cell(PERIOD_CELLS + 1, level);
    let cut = min(end - low + high + 2, end + 1);
    return Around(
        select(low, vec3<i32>(0), whole),
        select(select(high - low + 1, cut, before | after), end + 1, whole),
        select(vec3<i32>(2147483647), end, periodic),
    );
}

// The `k`th cell of those along an axis.
fn turned(start: i32, last: i32, k: i32) -> i32 {
    if start + k > last { return start + k - last - 1; }
    return start + k;
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
    while rest != 0u && rounds <= MOST_ROUNDS {
        let other_level = firstLeadingBit(rest);
        if other_level < level { break; }
        rest = finer(rest, other_level);
        let reach = lattice_reach(half) + level_reach(other_level) + WRAPPED_SLACK;
        let look = around(cell, vec3<i32>(min(reach, vec3<u32>(1073741824u))), other_level);
        let x_end = look.start.x + look.count.x - 1;
        let pieces = select(1u, 2u, x_end > look.last.x);
        for (var kz = 0; kz < look.count.z && rounds <= MOST_ROUNDS; kz += 1) {
            let z = turned(look.start.z, look.last.z, kz);
            for (var ky = 0; ky < look.count.y && rounds <= MOST_ROUNDS; ky += 1) {
                let y = turned(look.start.y, look.last.y, ky);
                let base = row(other_level, y, z);
                for (var piece = 0u; piece < pieces; piece += 1u) {
                    let from_x = select(look.start.x, 0, piece == 1u);
                    let to_x = select(min(x_end, look.last.x), x_end - look.last.x - 1, piece == 1u);
                    let first = (base + bitcast<u32>(from_x)) & parameters.mask;
                    let last = (base + bitcast<u32>(to_x)) & parameters.mask;
                    // If the row crosses the table's end, its other part is at the beginning.
                    let parts = select(1u, 2u, first > last);
                    for (var part = 0u; part < parts; part += 1u) {
                        let begin = select(starts[first], 0u, part == 1u);
                        let end = select(starts[last + 1u], parameters.bodies, part + 1u < parts);
                        rounds += end - begin + 1u;
                        if rounds > MOST_ROUNDS { break; }
                        for (var q = begin; q < end; q += 1u) {
                            let word = bitcast<u32>(cells[q].w);
                            let other = word & BODY_MASK;
                            let at = grid_cell(cells[q].xyz, other_level);
                            // Other levels and cells may share the columns.
                            if word >> LEVEL_SHIFT != other_level || at.y != y || at.z != z { continue; }
                            if at.x < from_x || at.x > to_x { continue; }
                            if other_level == level && other <= body { continue; }
                            if !touches(cell, remainder, half, q) { continue; }
                            if parameters.fill == 1u {
                                pairs[to + found] = vec2<u32>(min(body, other), max(body, other));
                            }
                            found += 1u;
                        }
                    }
                }
            }
        }
    }
    if rounds > MOST_ROUNDS { atomicOr(&crowds[0], CROWDED); }
    if parameters.fill == 1u { return; }
    list[body] = found;
    // As in find.wgsl.
    if found >= parameters.large && atomicAdd(&crowds[1], found) >= 0x80000000u - found { atomicOr(&crowds[0], TOO_MANY); }
}
