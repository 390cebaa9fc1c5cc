// Two ellipsoids: the largest n . delta - h_a(n) - h_b(n) over unit normals (see peak.wgsl).
//
// From a warm normal Newton converges at once. Without one, the start is the normal of a sequence of quadratic models.
// If the maximum is so deep that it may not be unique, Newton also starts from the axes of both bodies and from the
// common perpendiculars of each two of them.
//
// Degenerate cases: concentric bodies (no direction between centres; those axes are the starts); equal maxima (the
// first in the order of starts).

// Quadratic models solved before Newton starts.
const COLD_MODELS: u32 = 3u;
// Starts in deep overlap: six axes, nine common perpendiculars, the cold start, each both ways.
const DEEP_STARTS: u32 = 32u;

fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    return out_of_order(delta, a, b);
}

// A normal near the maximum, from the direction between the centres: n ~ (sum of M M^T / h + f)^-1 delta, the
// maximum of the function that bounds f from below with squares in place of the h, touching at the last normal.
fn cold_start(delta: vec3r, a: Support, b: Support) -> vec3r {
    let ma = mat3r(a.axes[0] * a.radii.x, a.axes[1] * a.radii.y, a.axes[2] * a.radii.z);
    let mb = mat3r(b.axes[0] * b.radii.x, b.axes[1] * b.radii.y, b.axes[2] * b.radii.z);
    var normal = unit_or(delta, vec3r(1.0, 0.0, 0.0));
    for (var i = 0u; i < COLD_MODELS; i += 1u) {
        let height_a = length(normal * ma);
        let height_b = length(normal * mb);
        let value = max(dot(normal, delta) - height_a - height_b, 0.0);
        let m = ma * transpose(ma) * (1.0 / height_a) + mb * transpose(mb) * (1.0 / height_b);
        let u = m[0] + vec3r(value, 0.0, 0.0);
        let v = m[1] + vec3r(0.0, value, 0.0);
        let w = m[2] + vec3r(0.0, 0.0, value);
        // Normalized, so that products of three stay in range.
        let scale = 1.0 / (height_a + height_b + value);
        let adjugate = vec3r(dot(cross(v, w), delta), dot(cross(w, u), delta), dot(cross(u, v), delta)) * (scale * scale);
        normal = unit_or(adjugate, normal);
    }
    return normal;
}

// The starts in deep overlap; zero for the common perpendicular of parallel axes.
fn deep_start(a: Support, b: Support, cold: vec3r, number: u32) -> vec3r {
    let k = number / 2u;
    var start = cold;
    if k < 3u {
        start = column(a.axes, k);
    } else if k < 6u {
        start = column(b.axes, k - 3u);
    } else if k < 15u {
        start = unit_or(cross(column(a.axes, (k - 6u) / 3u), column(b.axes, (k - 6u) % 3u)), vec3r(0.0, 0.0, 0.0));
    }
    return select(start, -start, (number & 1u) == 1u);
}

// Without an index into the matrix, which would be put in memory.
fn column(m: mat3r, k: u32) -> vec3r {
    return select(select(m[2], m[1], k == 1u), m[0], k == 0u);
}

fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let body_a = support_of(a);
    let body_b = support_of(b);
    let tie = TIE * (length(delta) + largest(a.sizes) + largest(b.sizes));
    let deep = -(least_curvature_radius(a.sizes) + least_curvature_radius(b.sizes));
    let cold = cold_start(delta, body_a, body_b);
    var start = unit_or(warm, cold);
    var found: Peak;
    var best: Peak;
    for (var i = 0u; i <= DEEP_STARTS; i += 1u) {
        if i > 0u {
            start = deep_start(body_a, body_b, cold, i - 1u);
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
