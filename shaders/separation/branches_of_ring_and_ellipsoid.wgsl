// The smooth branches of the separation of a ring and an ellipsoid: numbers 1 to 4 are the minima of the distance along
// the ring, in the order of their angles on it; of more than four, the nearest. They are counted up to WINDOW above the
// nearest, so that a minimum has the same number in all queries.

fn are_ring_and_ellipsoid(a: Placed, b: Placed) -> bool {
    return a.kind == TORUS && b.kind == ELLIPSOID || a.kind == ELLIPSOID && b.kind == TORUS;
}

// The ring, the ellipsoid about `delta`, and the minima that are counted.
struct RingAndEllipsoid {
    is_swapped: bool,
    around: Around,
    axes: mat3r,
    tube: real,
    half_thickness: real,
    minima: AroundPlaces,
}

fn ring_and_ellipsoid(delta: vec3r, a: Placed, b: Placed, nearest: real) -> RingAndEllipsoid {
    let swapped = a.kind != TORUS;
    var ring = a;
    var egg = b;
    if swapped {
        ring = b;
        egg = a;
    }
    let around = around_of(select(delta, -delta, swapped), ring_of(ring), egg);
    let tube = tube_radius(ring);
    let half_thickness = smallest(egg.sizes);
    let minima = minima_around(around, nearest + tube + WINDOW * (tube + half_thickness), false);
    return RingAndEllipsoid(swapped, around, body_axes(egg.orientation), tube, half_thickness, minima);
}

fn ring_and_ellipsoid_within(
    delta: vec3r, a: Placed, b: Placed, nearest: real, limit: real, most_active: real, pushed: u32,
) -> u32 {
    let tube = select(b.sizes.y, a.sizes.y, a.kind == TORUS);
    let roundness = least_curvature_radius(select(a.sizes, b.sizes, a.kind == TORUS));
    if !(nearest > -(tube + DEEPEST * roundness)) { return WHOLE; }
    let pair = ring_and_ellipsoid(delta, a, b, nearest);
    let most = limit + RING_ROUNDING * (tube + pair.around.size);
    var found = 0u;
    for (var k = 0u; k < pair.minima.count; k += 1u) {
        let bit = 2u << k;
        let separation = pair.minima.values[k] - tube;
        if separation <= most && (separation <= most_active || (pushed & bit) > 0u) { found |= bit; }
    }
    return select(WHOLE, found, found > 0u);
}

// The separation at the minimum of number k.
fn separation_of_ring_and_ellipsoid(delta: vec3r, a: Placed, b: Placed, nearest: real, k: u32) -> Separation {
    let pair = ring_and_ellipsoid(delta, a, b, nearest);
    let found = separation_around(pair.around, pair.axes, pair.minima.places[k - 1u], pair.tube);
    if pair.is_swapped {
        return Separation(found.separation, -found.normal, found.lever_b, found.lever_a);
    }
    return found;
}

// The slack by which ring and ellipsoid turn and slide.
fn slack_of_ring_and_ellipsoid(a: Placed, b: Placed, turned: vec3r, slid: real) -> real {
    let ring = select(b.sizes, a.sizes, a.kind == TORUS);
    let radii = select(a.sizes, b.sizes, a.kind == TORUS);
    let turning = length(turned) * 2.0 * min(ring.x, largest(radii));
    return turning + slid + LEAST_SLACK * (ring.y + smallest(radii));
}
