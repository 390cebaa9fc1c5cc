// Boxes are classified by size: the boxes of class k extend over at most 2^k lattice cells in any orientation. From the
// largest on, two classes share a level; a level has the index of its larger class. Everything is in integers.
//
// The survey has the set of classes, one bit each, whether a body is too far out, and from REACH on, for every class
// and axis, the largest reach of a box from its body, in lattice cells.
const CLASSES: u32 = 0u;
const FAR: u32 = 1u;
const REACH: u32 = 4u;

// A body and its level in one word. Level zero means a box that touches nothing.
const LEVEL_SHIFT: u32 = 27u;
const BODY_MASK: u32 = 0x7ffffffu;

// A length in lattice cells: rounded up, plus one for the remainders, plus some ulps of slack.
fn lattice_reach(length: vec3r) -> vec3<u32> {
    return vec3<u32>(min(ceil(length * (INVERSE_PITCH * (1.0 + 8.0 * EPSILON))), vec3r(1073741760.0))) + 1u;
}

// The classes finer than a level.
fn finer(classes: u32, level: u32) -> u32 {
    return classes & ((1u << (level - 1u)) - 1u);
}

fn level_of(classes: u32, class_: u32) -> u32 {
    var rest = classes;
    var level = firstLeadingBit(rest);
    for (var round = 0u; round < 16u && class_ + 1u < level; round += 1u) {
        rest = finer(rest, level);
        level = firstLeadingBit(rest);
    }
    return level;
}

// The cell of a level's grid.
fn grid_cell(cell: vec3<i32>, level: u32) -> vec3<i32> {
    var cell_of_level = cell >> vec3<u32>(max(level, FINER) - FINER);
    if PLANAR == 1u { cell_of_level.z = 0; }
    return cell_of_level;
}

// The start of a row of cells along x in the table of columns. Its cells are consecutive, modulo the table's size.
fn row(level: u32, y: i32, z: i32) -> u32 {
    var h = (bitcast<u32>(y) * 0x9e3779b1u) ^ (bitcast<u32>(z) * 0x85ebca77u + level * 0xc2b2ae3du);
    h = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12u)) * 0x297a2d39u;
    return h ^ (h >> 15u);
}
