// A circle and a point or segment: the nearest points of both, at the smaller of the minima of
// `circle_segment_minima.wgsl`.
//
// Degenerate cases: two equal minima (the first along the segment).

fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    return a.kind != TORUS;
}

// The ring is a.
fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let ring = ring_of(a);
    let axis = body_z(b.orientation) * select(real(0.0), real(1.0), b.kind == SPHEROCYLINDER);
    let half = half_segment(b);
    let size = length(delta) + ring.radius + half;
    var at = real(0.0);
    if half > 0.0 {
        let sides = place_sides(delta * ring.axes, axis * ring.axes, half, ring.radius, size);
        let before = place_minimum(sides, real(-1.0));
        let after = place_minimum(sides, real(1.0));
        at = select(before.at, after.at, after.distance < before.distance - TIE * size);
    }
    return thickened(nearest_at_place(delta, ring, axis, half, at, size), tube_radius(a), tube_radius(b));
}
