// The report of a stage, which the host reads.
struct Report {
    // 1 if a body has left its stored box: the list of candidate pairs is not complete.
    outside: atomic<u32>,
    // The first body whose pose is not finite; all bits set while every pose is finite.
    not_finite: atomic<u32>,
    // Pairs that overlap by more than the tolerance.
    violations: atomic<u32>,
    // Bits of the largest overlap as a 32-bit float; they have the order of the numbers.
    worst: atomic<u32>,
    // The first pair with this overlap; all bits set without one.
    worst_pair: atomic<u32>,
    // Its bodies.
    worst_a: u32,
    worst_b: u32,
    // Bits of the largest radius of a box as a 32-bit float.
    largest: atomic<u32>,
    // Bits of the largest displacement of a surface point in the step, as a 32-bit float.
    farthest: atomic<u32>,
    // Bits of the largest displacement of a surface point by rotation in the step, as a 32-bit float.
    turned: atomic<u32>,
    // If requested: bits of the largest distance of a body's start outside its stored box, as a 32-bit float.
    strayed: atomic<u32>,
    // If requested: 1 if a candidate pair may pass through each other.
    passing: atomic<u32>,
    // Bits of the largest displacement of a body's centre by contact from its free motion, as a 32-bit float.
    largest_move: atomic<u32>,
    // If requested: the first body with this displacement; else all bits set.
    moved: atomic<u32>,
    // Bits of the largest angle by which contact turns a body of revolution about its own axis, as a 32-bit float.
    axial_spin: atomic<u32>,
    // Bits of the largest separation of a pushing pair, as a 32-bit float.
    push_gap: atomic<u32>,
    // If requested: the first pushing pair with this separation; else all bits set.
    push_pair: atomic<u32>,
    // Pushing pairs that are farther apart than allowed.
    apart: atomic<u32>,
    // Pushing pairs that move their bodies farther against each other than allowed.
    thrown: atomic<u32>,
    padding: u32,
}
