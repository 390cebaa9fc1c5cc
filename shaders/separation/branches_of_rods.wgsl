// The smooth branches of the separation of two rods: number 0 is the separation itself, 1 and 2 are the ends of the
// first rod against the other, 3 and 4 those of the second.

// An end against the other segment: the points of the centrelines, the vector from the first to the second, and the bit
// of the other rod's end if both meet end to end.
struct End { from_a: vec3r, to_b: vec3r, gap: vec3r, met: u32 }

fn are_rods(a: Placed, b: Placed) -> bool {
    return a.kind == SPHEROCYLINDER && half_segment(a) > 0.0 && b.kind == SPHEROCYLINDER && half_segment(b) > 0.0;
}

// The end of number k.
fn end_of(delta: vec3r, a: Placed, b: Placed, k: u32) -> End {
    let axis_a = body_z(a.orientation);
    let axis_b = body_z(b.orientation);
    let half_a = half_segment(a);
    let half_b = half_segment(b);
    if k > 2u {
        let to_b = axis_b * select(half_b, -half_b, k == 3u);
        let place = clamp(dot(delta + to_b, axis_a), -half_a, half_a);
        var gap = delta + to_b - axis_a * place;
        // At a point that is not an end the gap is perpendicular to the axis; its component along the axis is rounding
        // and is dropped.
        if abs(place) < half_a { gap -= axis_a * dot(axis_a, gap); }
        return End(axis_a * place, to_b, gap, 0u);
    }
    let end = select(half_a, -half_a, k == 1u);
    let from_a = axis_a * end;
    let place = clamp(dot(from_a - delta, axis_b), -half_b, half_b);
    let to_b = axis_b * place;
    var gap = delta + to_b - from_a;
    if abs(place) < half_b { gap -= axis_b * dot(axis_b, gap); }
    var met = 0u;
    if clamp(dot(delta + to_b, axis_a), -half_a, half_a) == end {
        if place == -half_b { met = 8u; }
        if place == half_b { met |= 16u; }
    }
    return End(from_a, to_b, gap, met);
}

// Whether the common perpendicular of two segments ends inside both.
fn crosses_inside(delta: vec3r, a: Placed, b: Placed) -> bool {
    let axis_a = body_z(a.orientation);
    let axis_b = body_z(b.orientation);
    let across = cross(axis_a, axis_b);
    let sine2 = dot(across, across);
    if sine2 < PARALLEL_SINE * PARALLEL_SINE { return false; }
    let s = dot(delta, cross(axis_b, across)) / sine2;
    let t = dot(delta, cross(axis_a, across)) / sine2;
    return abs(s) < half_segment(a) && abs(t) < half_segment(b);
}

fn rods_within(delta: vec3r, a: Placed, b: Placed, nearest: real, limit: real, most_active: real, pushed: u32) -> u32 {
    let radii = tube_radius(a) + tube_radius(b);
    if !(nearest > -DEEPEST * radii) { return WHOLE; }
    let most = limit + BRANCH_ROUNDING * (radii + half_segment(a) + half_segment(b));
    var there = crosses_inside(delta, a, b);
    var found = select(0u, WHOLE, there);
    // The ends of b that were counted with an end of a.
    var met = 0u;
    for (var k = 1u; k < BRANCHES; k += 1u) {
        let bit = 1u << k;
        if (met & bit) > 0u { continue; }
        let end = end_of(delta, a, b, k);
        met |= end.met;
        let separation = length(end.gap) - radii;
        if separation > most { continue; }
        there = true;
        if separation <= most_active || (pushed & bit) > 0u { found |= bit; }
    }
    return select(WHOLE, found, there && found > 0u);
}

// The separation at the end of number k.
fn separation_of_rods(delta: vec3r, a: Placed, b: Placed, k: u32) -> Separation {
    let end = end_of(delta, a, b, k);
    let distance = length(end.gap);
    return thickened(Nearest(end.from_a, end.to_b, end.gap / distance, distance), tube_radius(a), tube_radius(b));
}

// In the plane the slack by which the rods turn and slide; in space only the rounding.
fn slack_of_rods(a: Placed, b: Placed, normal: vec3r, turned: vec3r, slid: real) -> real {
    let radii = tube_radius(a) + tube_radius(b);
    if !PLANAR { return SLACK_IN_SPACE * radii; }
    let tilt_a = abs(dot(turned, cross(body_z(a.orientation), normal)));
    let tilt_b = abs(dot(turned, cross(body_z(b.orientation), normal)));
    let tilted = max(tilt_a, tilt_b) * 2.0 * min(half_segment(a), half_segment(b));
    return tilted + 0.5 * slid * slid / radii + LEAST_SLACK * radii;
}
