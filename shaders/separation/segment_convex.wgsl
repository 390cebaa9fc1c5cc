// A superellipsoid and a thickened point or segment, as in src/separation/segment_convex.rs: either the normal is
// across the segment, or the contact is at an end. At a depth at which the maximum may not be unique, all local maxima
// from fixed starts are compared, across the segment and at both ends.
//
// Degenerate cases: a point at the centre, or a line through it (fixed starts); equal maxima (the first in the order of
// starts).

// The starts around a line.
const ROUND: u32 = 32u;
const ROUND_COSINE: real = 0.98078528040323044913;
const ROUND_SINE: real = 0.19509032201612826785;

// A maximum, and the position on the segment.
struct Candidate {
    peak: Peak,
    at: real,
}

// As `climb`, for one body and only over normals at right angles to the unit vector `axis`, of which `start` is one.
// The normal half way between two slopes of opposite signs is tried, too: beside a segment that is parallel to a flat
// place the others may go back and forth across it.
fn climb_across(delta: vec3r, body: Posed, axis: vec3r, start: vec3r) -> Peak {
    let size = length(delta) + body.norm.size;
    let point = at_a_point();
    var peak = peak_at(delta, body, point, start);
    var along: vec3r;
    var bend: vec2r;
    var slope = real(0.0);
    var step = real(0.0);
    var is_new = true;
    var rising = vec3r();
    var falling = vec3r();
    for (var round = 0u; round < PEAK_ROUNDS; round += 1u) {
        if is_new {
            along = cross(axis, peak.normal);
            slope = dot(along, delta - peak.point_a);
            let bends = bends_of(body.norm, peak.normal * body.axes);
            let u = along * body.axes;
            bend = vec2r(bend_along(bends, u, u), bend_along(bends, u, axis * body.axes));
            if abs(slope) <= GRADIENT_FLOOR * size { break; }
            if slope > 0.0 { rising = peak.normal; } else { falling = peak.normal; }
            let whole = peak.value + bend.x;
            step = select(sign(slope) * LONGEST_STEP, slope / whole, whole > 0.0);
            step = clamp(step, -LONGEST_STEP, LONGEST_STEP);
        }
        var best = peak;
        var gain = real(0.0);
        let is_between = dot(rising, rising) > 0.0 && dot(falling, falling) > 0.0;
        for (var k = 0u; k < select(2u, 3u, is_between); k += 1u) {
            var normal = normalize(peak.normal + along * step);
            if k == 2u { normal = unit_or(rising + falling, normal); }
            if k == 1u {
                let through = normal_through(body, peak.point_a + (along * bend.x + axis * bend.y) * step, normal);
                normal = unit_or(through - axis * dot(axis, through), normal);
            }
            let tried = peak_at(delta, body, point, normal);
            if tried.value > best.value { best = tried; }
            if k < 2u {
                gain = max(gain, slope * dot(along, normal));
            } else if dot(cross(axis, normal), delta - tried.point_a) > 0.0 {
                rising = normal;
            } else {
                falling = normal;
            }
        }
        is_new = best.value > peak.value + GAIN * size;
        if is_new {
            peak = best;
        } else {
            step *= SHORTEN;
            if !(gain > VALUE_FLOOR * size) { break; }
        }
    }
    let moved = peak.point_a + (along + axis * (bend.y / bend.x)) * slope;
    if is_on(body, moved) { peak.point_a = moved; }
    return peak;
}

// Whether an end has the smallest coordinate along the normal of the whole segment, as required at a maximum.
fn is_nearest(peak: Peak, end: real, axis: vec3r) -> bool {
    return end * dot(peak.normal, axis) <= 0.0;
}

// The maximum for the segment about `delta` and the body about the origin. The first round has one start across and one
// at each end; the second, of deep bodies, has all.
fn nearest_candidate(delta: vec3r, body: Posed, axis: vec3r, half: real) -> Candidate {
    let tie = TIE * (length(delta) + body.norm.size + half);
    let deep = -body.norm.roundness;
    let beside = unit_or(part_across(delta, axis), perpendicular(axis));
    let first = perpendicular(axis);
    let second = cross(axis, first);
    var nearer = half;
    var best: Candidate;
    for (var round = 0u; round < 2u; round += 1u) {
        best.peak.value = -HUGE;
        var turn = vec2r(1.0, 0.0);
        let rounds = select(select(1u, ROUND, round == 1u), 0u, half == 0.0);
        for (var k = 0u; k < rounds; k += 1u) {
            var start = beside;
            if round == 1u { start = normalize(first * turn.x + second * turn.y); }
            let peak = climb_across(delta, body, axis, start);
            let at = dot(peak.point_a - delta, axis);
            if round == 0u {
                if peak.value > deep && abs(at) <= half { return Candidate(peak, at); }
                nearer = select(half, -half, at < 0.0);
            } else if peak.value > best.peak.value + tie {
                best = Candidate(peak, clamp(at, -half, half));
            }
            turn = vec2r(turn.x * ROUND_COSINE - turn.y * ROUND_SINE, turn.y * ROUND_COSINE + turn.x * ROUND_SINE);
        }
        let ends = select(2u, 1u, half == 0.0);
        let starts = select(1u, STARTS + 1u, round == 1u);
        for (var i = 0u; i < ends * starts; i += 1u) {
            let k = i % starts;
            // The deepest are compared in a fixed order of the ends.
            let side = select(nearer, -half, round == 1u);
            let end = select(side, -side, i >= starts);
            let p = delta + axis * end;
            var start = unit_or(p, beside);
            if k > 0u { start = start_of(body, k - 1u); }
            if dot(start, start) == 0.0 { continue; }
            let peak = climb(p, body, at_a_point(), start);
            if !is_nearest(peak, end, axis) { continue; }
            if round == 0u && peak.value > deep { return Candidate(peak, end); }
            if peak.value > best.peak.value + tie { best = Candidate(peak, end); }
        }
    }
    return best;
}

fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    return !is_superellipsoid(a.kind);
}

// The superellipsoid is a.
fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let body = posed(a);
    let axis = body_z(b.orientation);
    let found = nearest_candidate(delta, body, axis, half_segment(b));
    let radius = tube_radius(b);
    let normal = found.peak.normal;
    // Across from the segment's point, if that is on a flat place.
    let across = delta + axis * found.at - normal * found.peak.value;
    var lever = found.peak.point_a;
    if is_on(body, across) { lever = across; }
    return Separation(found.peak.value - radius, normal, lever, axis * found.at - normal * radius);
}
