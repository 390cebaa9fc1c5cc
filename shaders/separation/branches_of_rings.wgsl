// The smooth branches of the separation of two rings: numbers 1 to 4 are the minima of the distance along the smaller
// ring, in the order of their angles on it; along the second if both have the same size. They are counted up to WINDOW
// above the nearest, so that a minimum has the same number in all queries.

fn are_rings(a: Placed, b: Placed) -> bool {
    return a.kind == TORUS && b.kind == TORUS;
}

// Two rings, the larger one first, and the minima that are counted.
struct RingBranches { is_swapped: bool, delta: vec3r, ring_a: Ring, ring_b: Ring, size: real, minima: RingPlaces }

fn branches_of_rings(delta: vec3r, a: Placed, b: Placed, nearest: real) -> RingBranches {
    let swapped = a.sizes.x < b.sizes.x;
    let from_a = select(delta, -delta, swapped);
    var ring_a = ring_of(a);
    var ring_b = ring_of(b);
    if swapped {
        ring_a = ring_of(b);
        ring_b = ring_of(a);
    }
    let radii = tube_radius(a) + tube_radius(b);
    let size = length(delta) + ring_a.radius + ring_b.radius;
    let most = nearest + radii + WINDOW * radii;
    let minima = ring_minima(ring_pair(from_a, ring_a, ring_b), size, most, false);
    return RingBranches(swapped, from_a, ring_a, ring_b, size, minima);
}

fn at_minimum(rings: RingBranches, k: u32) -> Nearest {
    return nearest_at(rings.delta, rings.ring_a, rings.ring_b, rings.minima.places[k], rings.size);
}

fn rings_within(delta: vec3r, a: Placed, b: Placed, nearest: real, limit: real, most_active: real, pushed: u32) -> u32 {
    let radii = tube_radius(a) + tube_radius(b);
    if !(nearest > -DEEPEST * radii) { return WHOLE; }
    let rings = branches_of_rings(delta, a, b, nearest);
    let most = limit + RING_ROUNDING * (radii + rings.size);
    var found = 0u;
    for (var k = 0u; k < rings.minima.count; k += 1u) {
        let bit = 2u << k;
        let separation = at_minimum(rings, k).distance - radii;
        if separation <= most && (separation <= most_active || (pushed & bit) > 0u) { found |= bit; }
    }
    return select(WHOLE, found, found > 0u);
}

// The separation at the minimum of number k.
fn separation_of_rings(delta: vec3r, a: Placed, b: Placed, nearest: real, k: u32) -> Separation {
    let rings = branches_of_rings(delta, a, b, nearest);
    let at = at_minimum(rings, k - 1u);
    if rings.is_swapped {
        let found = thickened(at, tube_radius(b), tube_radius(a));
        return Separation(found.separation, -found.normal, found.lever_b, found.lever_a);
    }
    return thickened(at, tube_radius(a), tube_radius(b));
}

// The slack by which the rings turn and slide.
fn slack_of_rings(a: Placed, b: Placed, turned: vec3r, slid: real) -> real {
    let turning = length(turned) * 2.0 * min(a.sizes.x, b.sizes.x);
    return turning + slid + LEAST_SLACK * (tube_radius(a) + tube_radius(b));
}
