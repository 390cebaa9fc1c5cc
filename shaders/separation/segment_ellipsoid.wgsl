// An ellipsoid and a thickened point or segment: the largest n . delta - h(n) - half |n . u| - radius over unit
// normals.
//
// Either the normal is across the segment, and then it is that of a point and the ellipse that is the ellipsoid's
// shadow along the segment; or the contact is at an end, and then it is that of a point and the ellipsoid. Both are one
// root (point_ellipsoid.wgsl), and at most three are computed: the distance along the segment's line is convex, so if
// its nearest point is beyond an end, that end is nearest. Everything is in the ellipsoid's axes, where a normal's
// small components keep their digits, and with them the points of flat bodies.
//
// Degenerate cases: a segment so deep that the distance along it is no longer smooth (all candidates are compared; the
// first among equals counts); a point or a line through the centre (see point_ellipsoid.wgsl).

// Starts at each end in deep overlap: both directions of each axis.
const END_STARTS: u32 = 6u;

// A normal with the ellipsoid's point, the position on the segment, and the distance along the normal between them.
struct Candidate {
    normal: vec3r,
    point: vec3r,
    at: real,
    value: real,
}

// The largest of all local maxima: across the line, at both ends, and at both ends from starts along the ellipsoid's
// axes.
fn deepest_candidate(delta: vec3r, axis: vec3r, half: real, radii: vec3r, across: Candidate, near: Candidate, far: Candidate) -> Candidate {
    let identity = mat3r(vec3r(1.0, 0.0, 0.0), vec3r(0.0, 1.0, 0.0), vec3r(0.0, 0.0, 1.0));
    let tie = TIE * (length(delta) + largest(radii) + half);
    var best = across;
    best.at = clamp(across.at, -half, half);
    // Beyond an end it is not a maximum; one that is equal up to rounding replaces it.
    var lead = select(tie, -tie, best.at != across.at);
    for (var i = 0u; i < 2u * (END_STARTS + 1u); i += 1u) {
        let end = select(half, -half, i <= END_STARTS);
        let number = i % (END_STARTS + 1u);
        var candidate = far;
        if near.at == end { candidate = near; }
        if number > 0u {
            let k = (number - 1u) / 2u;
            let sign_of = select(real(-1.0), real(1.0), (number & 1u) == 1u);
            let start = select(vec3r(0.0, 0.0, 0.0), vec3r(sign_of), vec3<u32>(k) == vec3<u32>(0u, 1u, 2u));
            let peak = climb(delta + axis * end, Support(identity, radii), Support(identity, vec3r(0.0, 0.0, 0.0)), start);
            candidate = Candidate(peak.normal, peak.point_a, end, peak.value);
        }
        if candidate.at * dot(candidate.normal, axis) <= 0.0 && candidate.value > best.value + lead {
            best = candidate;
            lead = tie;
        }
    }
    return best;
}

// The nearest points of an ellipsoid about the origin and a segment about `delta`; `first` and `second` are at right
// angles to its axis. Everything is in the ellipsoid's axes.
fn nearest_candidate(delta: vec3r, axis: vec3r, half: real, radii: vec3r, first: vec3r, second: vec3r) -> Candidate {
    // The shadow's axes: one plane rotation of the two columns of diag(radii) (first, second), which keeps the digits
    // of the smaller one.
    let v1 = radii * first;
    let v2 = radii * second;
    let turn = half_turn(2.0 * dot(v1, v2), dot(v1, v1) - dot(v2, v2));
    let e1 = first * turn.x + second * turn.y;
    let e2 = second * turn.x - first * turn.y;
    let w1 = v1 * turn.x + v2 * turn.y;
    let w2 = v2 * turn.x - v1 * turn.y;
    var across: Candidate;
    var near: Candidate;
    var end = real(0.0);
    for (var round = select(0u, 1u, half == 0.0); ; round += 1u) {
        var root_radii = radii;
        var root_point = delta + axis * end;
        if round == 0u {
            root_radii = vec3r(length(w1), length(w2), length(w1) + length(w2));
            root_point = vec3r(dot(delta, e1), dot(delta, e2), 0.0);
        }
        let n = point_ellipsoid_normal(root_radii, root_point);
        var normal = n;
        var scaled = radii * n;
        if round == 0u {
            normal = e1 * n.x + e2 * n.y;
            scaled = w1 * n.x + w2 * n.y;
        }
        let height = length(scaled);
        var here = Candidate(normal, radii * (scaled / height), end, dot(n, root_point) - height);
        let is_smooth = here.value > -least_curvature_radius(radii);
        if half == 0.0 { return here; }
        if round == 0u {
            here.at = dot(here.point - delta, axis);
            if is_smooth && abs(here.at) <= half { return here; }
            across = here;
            end = select(half, -half, here.at < 0.0);
        } else {
            // At an end, the whole segment must be farther along the normal.
            if is_smooth && end * dot(normal, axis) <= 0.0 { return here; }
            if round == 2u {
                return deepest_candidate(delta, axis, half, radii, across, near, here);
            }
            near = here;
            end = -end;
        }
    }
    return across;
}

fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    return a.kind != ELLIPSOID;
}

// The ellipsoid is a.
fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let axes = body_axes(a.orientation);
    let axis = body_z(b.orientation);
    let sides = orthonormal_pair(axis);
    let found = nearest_candidate(delta * axes, axis * axes, half_segment(b), a.sizes, sides.first * axes, sides.second * axes);
    let normal = axes * found.normal;
    let radius = tube_radius(b);
    return Separation(found.value - radius, normal, axes * found.point, axis * found.at - normal * radius);
}
