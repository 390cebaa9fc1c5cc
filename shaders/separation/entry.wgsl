// The separation of a pair of two families, computed in one fixed order: swapping the bodies flips the normal.
fn space_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    var first = a;
    var second = b;
    let swap = is_swapped(delta, a, b);
    if swap {
        first = b;
        second = a;
    }
    let side = select(real(1.0), real(-1.0), swap);
    let found = ordered_separation(delta * side, first, second, warm * side);
    if swap {
        return Separation(found.separation, -found.normal, found.lever_b, found.lever_a);
    }
    return found;
}
