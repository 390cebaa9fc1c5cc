// A point and an ellipsoid or an ellipse: the outward normal at the nearest surface point, also from inside, and at the
// farthest, for which excesses refer to the longest axis and the normal is opposite.
//
// With tau as the unknown, the nearest point's normal is along p_i / (tau + a_i^2 - a_min^2), where tau is the largest
// root of sum (a_i p_i / (tau + a_i^2 - a_min^2))^2 = 1. The reciprocal of the root of the sum is concave and nearly
// linear in tau: Newton's method on it climbs to the root from below without a safeguard (D. Eberly; J. More and D.
// Sorensen, SIAM J. Sci. Stat. Comput. 4, 553, 1983).
//
// Degenerate case: a point with no component along the least axis and within the focal set: the side of the first
// shortest (longest) axis on which the point is, else the positive one.

// The largest number of steps; on the CPU none took more than 20, at aspect ratios up to 1000.
const POINT_ELLIPSOID_STEPS: u32 = 60u;

// sum w^2 and sum w^2 / (tau + excess) with w = a p / (tau + excess); components that are zero on a pole count as zero.
fn pole_sums(scaled: vec3r, poles: vec3r) -> vec2r {
    let open = poles > vec3r(0.0, 0.0, 0.0);
    let inverse = select(vec3r(0.0, 0.0, 0.0), 1.0 / poles, open);
    let w = scaled * inverse;
    return vec2r(dot(w, w), dot(w * w, inverse));
}

// The unit normal at the surface point nearest to `p`, in the ellipsoid's own axes. Each component keeps its digits,
// even if small. An ellipse has a third radius, larger than another, and p.z = 0.
fn point_ellipsoid_normal(radii: vec3r, p: vec3r) -> vec3r {
    let least = min(radii.x, min(radii.y, radii.z));
    return along_poles(radii, p, (radii - vec3r(least)) * (radii + vec3r(least)));
}

// The same at the point farthest from `p`. An ellipse has a third radius of zero, and p.z = 0; all radii except the
// largest may be zero.
fn farthest_normal(radii: vec3r, p: vec3r) -> vec3r {
    let greatest = max(radii.x, max(radii.y, radii.z));
    return -along_poles(radii, p, (vec3r(greatest) - radii) * (vec3r(greatest) + radii));
}

// The unit vector along p_i / (tau + excess_i) for the root tau of sum (a_i p_i / (tau + excess_i))^2 = 1.
fn along_poles(radii: vec3r, p: vec3r, excess: vec3r) -> vec3r {
    let scaled = radii * p;
    let begin = abs(scaled) - excess;
    var tau = max(begin.x, max(begin.y, begin.z));
    if tau < TINY {
        tau = 0.0;
        let flat_sum = pole_sums(scaled, excess).x;
        if flat_sum <= 1.0 {
            // On the focal set: the other components have tau at the pole, and the remaining component is along the
            // first axis without excess.
            var n = select(vec3r(0.0, 0.0, 0.0), p / excess, excess > vec3r(0.0, 0.0, 0.0));
            let left = sqrt(1.0 - flat_sum) / radii;
            if excess.x <= 0.0 {
                n.x = select(left.x, -left.x, p.x < 0.0);
            } else if excess.y <= 0.0 {
                n.y = select(left.y, -left.y, p.y < 0.0);
            } else {
                n.z = select(left.z, -left.z, p.z < 0.0);
            }
            return normalize(n);
        }
    }
    for (var i = 0u; i < POINT_ELLIPSOID_STEPS; i += 1u) {
        let sums = pole_sums(scaled, excess + vec3r(tau));
        let step = sums.x / sums.y * (sqrt(sums.x) - 1.0);
        if !(step > EPSILON * tau) { break; }
        tau += step;
    }
    let poles = excess + vec3r(tau);
    return normalize(select(vec3r(0.0, 0.0, 0.0), p / poles, poles > vec3r(0.0, 0.0, 0.0)));
}
