// The support function of an ellipsoid in space and its derivatives, without cancellation.
//
// With M = R diag(radii): h(n) = |M^T n|, the contact point is M M^T n / h, and the Hessian across n follows from the
// cofactors of M: for tangents e1, e2 and K = diag(bc, ca, ab) R^T it is |K e2|^2 / h^3, -K e1 . K e2 / h^3, |K e1|^2 /
// h^3.

// An ellipsoid about the origin: its axes in space, as columns, and its semi-axes. Semi-axes of zero are a point.
struct Support {
    axes: mat3r,
    radii: vec3r,
}

fn support_of(p: Placed) -> Support {
    return Support(body_axes(p.orientation), p.sizes);
}

fn largest(v: vec3r) -> real {
    return max(v.x, max(v.y, v.z));
}

fn smallest(v: vec3r) -> real {
    return min(v.x, min(v.y, v.z));
}

// The Hessian across n in the tangent basis, as (11, 12, 22), given the value at n.
fn support_hessian(s: Support, height: real, e1: vec3r, e2: vec3r) -> vec3r {
    let cofactors = s.radii.yzx * s.radii.zxy / height;
    let k1 = cofactors * (e1 * s.axes);
    let k2 = cofactors * (e2 * s.axes);
    return vec3r(dot(k2, k2), -dot(k1, k2), dot(k1, k1)) / height;
}

// The smallest radius of curvature: a ball of this radius rolls freely inside.
fn least_curvature_radius(radii: vec3r) -> real {
    let least = smallest(radii);
    return least * least / largest(radii);
}

// Largest over smallest semi-axis; one for a point.
fn aspect_of(radii: vec3r) -> real {
    let least = smallest(radii);
    return select(real(1.0), largest(radii) / least, least > 0.0);
}
