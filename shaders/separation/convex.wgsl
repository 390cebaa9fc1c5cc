// A superellipsoid with another, or with an ellipsoid: the largest n . delta - h_a(n) - h_b(n) over unit normals (see
// flat.wgsl). The search starts at the warm normal or at the direction between the centres. If the maximum is so deep
// that it may not be unique, it also starts from fixed normals of both bodies, of two superellipsoids also from those
// across an axis of each.
//
// Degenerate cases: concentric bodies (the start is the x of space); equal maxima (the first in the order of starts).

// The starts across an axis of each body.
const CROSSINGS: u32 = 18u;

fn axis_of(body: Posed, k: u32) -> vec3r {
    return select(select(body.axes[0], body.axes[1], k == 1u), body.axes[2], k == 2u);
}

fn crossing(a: Posed, b: Posed, k: u32) -> vec3r {
    let normal = unit_or(cross(axis_of(a, k % 3u), axis_of(b, k / 3u % 3u)), vec3r());
    return select(normal, -normal, k >= CROSSINGS / 2u);
}

fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    if a.kind == ELLIPSOID { return false; }
    if b.kind == ELLIPSOID { return true; }
    let same = all(delta == vec3r()) && bounding_radius(a) == bounding_radius(b) && all(a.orientation == b.orientation);
    if !same || thickness(a) != thickness(b) { return out_of_order(delta, a, b); }
    if any(a.sizes != b.sizes) { return first_sign(vec4r(b.sizes - a.sizes, 0.0)) < 0.0; }
    return first_sign(vec4r(exponents_of(b.kind).exponents - exponents_of(a.kind).exponents, 0.0, 0.0)) < 0.0;
}

fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let body_a = posed(a);
    let body_b = posed(b);
    let tie = TIE * (length(delta) + body_a.norm.size + body_b.norm.size);
    let deep = -(body_a.norm.roundness + body_b.norm.roundness);
    let between = unit_or(delta, vec3r(1.0, 0.0, 0.0));
    var start = unit_or(warm, between);
    var found: Peak;
    var best: Peak;
    let crossings = select(0u, CROSSINGS, a.kind != ELLIPSOID && b.kind != ELLIPSOID);
    // The first, then those along the axes of both, the one between, those at the edges of both, and across both.
    for (var i = 0u; i <= 2u * STARTS + 1u + crossings; i += 1u) {
        if i == 2u * AROUND + 1u {
            start = between;
        } else if i > 2u * STARTS + 1u {
            start = crossing(body_a, body_b, i - 2u * STARTS - 2u);
            if dot(start, start) == 0.0 { continue; }
        } else if i > 0u {
            let k = i - select(1u, 2u, i > 2u * AROUND);
            let number = k % AROUND + select(0u, AROUND, k >= STARTS);
            if (k / AROUND) % 2u == 0u { start = start_of(body_a, number); } else { start = start_of(body_b, number); }
            if dot(start, start) == 0.0 { continue; }
        }
        let peak = climb(delta, body_a, body_b, start);
        if i == 0u {
            found = peak;
            if peak.value > deep { break; }
        } else if i == 1u || peak.value > best.value + tie {
            best = peak;
        }
    }
    // The first result only if it is larger than all, so that among equal maxima the result does not depend on a warm
    // normal.
    if found.value <= deep && found.value <= best.value + tie {
        found = best;
    }
    return Separation(found.value, found.normal, found.point_a, -found.point_b);
}
