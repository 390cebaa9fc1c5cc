// The nearest points of two segments; a point is a segment of zero length.
//
// The foot of the common perpendicular comes from the cross product of the axes, not from 1 - cos^2, and is clamped to
// the segment; the position on the other is optimal for it and clamped, then the first is optimal for that (D. Eberly,
// "Robust computation of distance between line segments"; C. Ericson, "Real-time collision detection", 5.1.9).
//
// Degenerate cases: a segment of zero length; parallel axes (the middle of the interval in which they face each other);
// crossing segments and points that coincide (`normal_between`).

fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    return out_of_order(delta, a, b);
}

fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    // A sphere has no axis.
    let axis_a = body_z(a.orientation) * select(real(0.0), real(1.0), a.kind == SPHEROCYLINDER);
    let axis_b = body_z(b.orientation) * select(real(0.0), real(1.0), b.kind == SPHEROCYLINDER);
    let half_a = half_segment(a);
    let half_b = half_segment(b);
    let across = cross(axis_a, axis_b);
    let sine2 = dot(across, across);
    let cosine = dot(axis_a, axis_b);
    let along_a = dot(delta, axis_a);
    let along_b = dot(delta, axis_b);
    var foot = along_a;
    if sine2 > 0.0 {
        foot = dot(delta, cross(axis_b, across)) / sine2;
    }
    var t = clamp(cosine * clamp(foot, -half_a, half_a) - along_b, -half_b, half_b);
    var s = clamp(cosine * t + along_a, -half_a, half_a);
    // At a point that is not an end the gap is perpendicular to the axis; its component along the axis is rounding and
    // is dropped.
    var gap = delta + axis_b * t - axis_a * s;
    let inside_a = abs(s) < half_a;
    let inside_b = abs(t) < half_b;
    if inside_a { gap -= axis_a * dot(axis_a, gap); }
    if inside_b { gap -= axis_b * dot(axis_b, gap); }
    let distance = length(gap);
    let size = half_a + half_b + length(delta);
    let normal = normal_between(course_of(axis_a, half_a, s), course_of(axis_b, half_b, t), gap, distance, size, delta);
    // The nearest point of nearly parallel axes jumps from end to end as the angle changes sign; the transition to the
    // middle is a smooth function of the angle.
    let low = max(-half_a, along_a - half_b);
    let high = min(half_a, along_a + half_b);
    if sine2 < 1e3 * PARALLEL_SINE * PARALLEL_SINE && half_a > 0.0 && half_b > 0.0 && low < high {
        let middle = 0.5 * (low + high);
        let opposite = clamp(cosine * middle - along_b, -half_b, half_b);
        let angle = sine2 / (PARALLEL_SINE * PARALLEL_SINE);
        let weight = 1.0 / (1.0 + angle * angle);
        s += weight * (middle - s);
        t += weight * (opposite - t);
    }
    return thickened(Nearest(axis_a * s, axis_b * t, normal, distance), tube_radius(a), tube_radius(b));
}
