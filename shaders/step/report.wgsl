// What the host reads of a stage.
struct Report {
    // 1 where a body has left its stored box: the list of candidate pairs is not complete.
    outside: atomic<u32>,
    // The first body whose pose is not finite; all bits set while every pose is finite.
    not_finite: atomic<u32>,
    // Pairs that overlap by more than the tolerance.
    violations: atomic<u32>,
    // Bits of the largest overlap as a 32-bit float, which order as the numbers do.
    worst: atomic<u32>,
    // The first pair that overlaps by that; all bits set where none does.
    worst_pair: atomic<u32>,
    // Its bodies.
    worst_a: u32,
    worst_b: u32,
    // Bits of the largest radius of a box as a 32-bit float.
    largest: atomic<u32>,
    // Bits of the farthest that a point of a surface moves in the step, as a 32-bit float.
    farthest: atomic<u32>,
    // Bits of the farthest that a turn moves a point of a surface in the step, as a 32-bit float.
    turned: atomic<u32>,
    // Where it is asked for: bits of the farthest that a body starts outside its stored box, as a 32-bit float.
    strayed: atomic<u32>,
    // Where it is asked for: 1 where a candidate pair may pass through each other.
    passing: atomic<u32>,
    // Bits of the farthest that contact moves a body's centre from where its free motion leads, as a 32-bit float.
    largest_move: atomic<u32>,
    // Where it is asked for: the first body that it moves by that; else all bits set.
    moved: atomic<u32>,
    // Bits of the largest angle by which contact turns a body of revolution about its own axis, as a 32-bit float.
    axial_spin: atomic<u32>,
    // Bits of the largest separation of a pair that pushes, as a 32-bit float.
    push_gap: atomic<u32>,
    // Where it is asked for: the first pair that pushes at that separation; else all bits set.
    push_pair: atomic<u32>,
    // Pairs that push and are farther apart than may be.
    apart: atomic<u32>,
    // Pairs that push and move their bodies farther against each other than may be.
    thrown: atomic<u32>,
    padding: u32,
}
