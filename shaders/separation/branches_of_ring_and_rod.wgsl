// The smooth branches of the separation of a ring and a rod: number 1 is the minimum of the distance before the point
// of the rod nearest to the ring's axis, number 2 the one after it.

fn are_ring_and_rod(a: Placed, b: Placed) -> bool {
    let first = a.kind == TORUS && b.kind == SPHEROCYLINDER && half_segment(b) > 0.0;
    return first || (b.kind == TORUS && a.kind == SPHEROCYLINDER && half_segment(a) > 0.0);
}

// The ring and the rod about `delta`.
struct RingAndRod { is_swapped: bool, delta: vec3r, ring: Ring, axis: vec3r, half: real, size: real, sides: PlaceSides }

fn ring_and_rod(delta: vec3r, a: Placed, b: Placed) -> RingAndRod {
    let swapped = a.kind != TORUS;
    var of_ring = a;
    var of_rod = b;
    if swapped {
        of_ring = b;
        of_rod = a;
    }
    let to_rod = select(delta, -delta, swapped);
    let ring = ring_of(of_ring);
    let axis = body_z(of_rod.orientation);
    let half = half_segment(of_rod);
    let size = length(delta) + ring.radius + half;
    let sides = place_sides(to_rod * ring.axes, axis * ring.axes, half, ring.radius, size);
    return RingAndRod(swapped, to_rod, ring, axis, half, size, sides);
}

// If the distance keeps falling beyond the piece, its border is not a minimum; otherwise both pieces have it.
fn is_minimum(pair: RingAndRod, found: PlaceMinimum) -> bool {
    return found.outer != found.inner && (abs(found.at - found.inner) > TIE * pair.size || abs(found.at) == pair.half);
}

fn ring_and_rod_within(
    delta: vec3r, a: Placed, b: Placed, nearest: real, limit: real, most_active: real, pushed: u32,
) -> u32 {
    let radii = tube_radius(a) + tube_radius(b);
    if !(nearest > -DEEPEST * radii) { return WHOLE; }
    let pair = ring_and_rod(delta, a, b);
    let most = limit + BRANCH_ROUNDING * (radii + pair.size);
    var found = 0u;
    for (var k = 1u; k <= 2u; k += 1u) {
        let at = place_minimum(pair.sides, select(real(-1.0), real(1.0), k == 2u));
        let separation = at.distance - radii;
        let bit = 1u << k;
        let wanted = separation <= most_active || (pushed & bit) > 0u;
        if is_minimum(pair, at) && separation <= most && wanted { found |= bit; }
    }
    return select(WHOLE, found, found > 0u);
}

// The separation at the minimum of number k.
fn separation_of_ring_and_rod(delta: vec3r, a: Placed, b: Placed, k: u32) -> Separation {
    let pair = ring_and_rod(delta, a, b);
    let at = place_minimum(pair.sides, select(real(-1.0), real(1.0), k == 2u)).at;
    let found = nearest_at_place(pair.delta, pair.ring, pair.axis, pair.half, at, pair.size);
    if pair.is_swapped {
        let turned = thickened(found, tube_radius(b), tube_radius(a));
        return Separation(turned.separation, -turned.normal, turned.lever_b, turned.lever_a);
    }
    return thickened(found, tube_radius(a), tube_radius(b));
}

// The slack by which ring and rod turn and slide.
fn slack_of_ring_and_rod(a: Placed, b: Placed, turned: vec3r, slid: real) -> real {
    let ring_radius = select(b.sizes.x, a.sizes.x, a.kind == TORUS);
    let half = max(half_segment(a), half_segment(b));
    return length(turned) * 2.0 * min(ring_radius, half) + slid + LEAST_SLACK * (tube_radius(a) + tube_radius(b));
}
