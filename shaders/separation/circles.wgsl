// Two circles: the nearest points of two circles in space, at the smallest of the minima of `circle_minima.wgsl`.
//
// Degenerate cases: circles with a constant distance (angle zero); circles that meet (`normal_between`); equal minima
// (the first).

// The larger ring comes first, so that two samples do not skip a feature of it.
fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    return select(out_of_order(delta, a, b), a.sizes.x < b.sizes.x, a.sizes.x != b.sizes.x);
}

fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let ring_a = ring_of(a);
    let ring_b = ring_of(b);
    let size = length(delta) + ring_a.radius + ring_b.radius;
    let place = ring_minima(ring_pair(delta, ring_a, ring_b), size, HUGE, true).places[0];
    return thickened(nearest_at(delta, ring_a, ring_b, place, size), tube_radius(a), tube_radius(b));
}
