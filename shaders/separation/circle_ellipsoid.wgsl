// A circle and an ellipsoid: the least distance of the circle's points to the ellipsoid, at the smallest of the minima
// of `circle_ellipsoid_minima.wgsl`.
//
// Degenerate cases: a constant distance (angle zero); equal minima (the first).

fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    return a.kind != TORUS;
}

// The ring is a.
fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let around = around_of(delta, ring_of(a), b);
    let place = minima_around(around, HUGE, true).places[0];
    return separation_around(around, body_axes(b.orientation), place, tube_radius(a));
}
