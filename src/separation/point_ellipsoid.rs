//! A point and an ellipsoid or an ellipse: the outward normal at the nearest surface point, also from inside, and at
//! the farthest.
//!
//! The nearest point `y` satisfies `p = y + t y / a^2` for the largest root `t` of `sum (a_i p_i / (t + a_i^2))^2 = 1`,
//! and the normal is along `p_i / (t + a_i^2)` (D. Eberly, "Distance from a point to an ellipse, an ellipsoid, or a
//! hyperellipsoid"). With `tau = t + a_min^2` as the unknown there is no cancellation near the pole. The reciprocal of
//! the root of the sum is concave and nearly linear in `tau`, so Newton's method on it climbs to the root from below
//! without a safeguard (J. More and D. Sorensen, SIAM J. Sci. Stat. Comput. 4, 553, 1983). This finds the globally
//! nearest point at any depth.
//!
//! The farthest point satisfies the same equation with its smallest root, `t` below `-a_max^2`. With `tau = -t -
//! a_max^2` it is the same problem, with poles at `a_max^2 - a_i^2` and the opposite normal.
//!
//! Degenerate case: a point with no component along the least (greatest) axis and within the focal set has two nearest
//! (farthest) points, or a circle of them, or the sphere: the result is the nearest on the positive, or the farthest on
//! the negative side of the first such axis.

/// The largest number of steps; over thousands of random poses none took more than 20, at aspect ratios up to 1000.
const MAX_STEPS: usize = 100;

/// The unit normal at the surface point nearest to `p`, in the ellipsoid's own axes.
pub(super) fn normal<const N: usize>(radii: [f64; N], p: [f64; N]) -> [f64; N] {
    let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
    along_poles(radii, p, radii.map(|a| (a - least) * (a + least)))
}

/// The unit normal at the surface point farthest from `p`, in the ellipsoid's own axes. All radii except the largest
/// may be zero: an ellipse seen edge-on.
pub(super) fn farthest_normal<const N: usize>(radii: [f64; N], p: [f64; N]) -> [f64; N] {
    let greatest = radii.iter().copied().fold(0.0, f64::max);
    along_poles(radii, p, radii.map(|a| (greatest - a) * (greatest + a))).map(|n| -n)
}

/// The unit vector along `p_i / (tau + excess_i)` for the root `tau` of `sum (a_i p_i / (tau + excess_i))^2 = 1`.
fn along_poles<const N: usize>(radii: [f64; N], p: [f64; N], excess: [f64; N]) -> [f64; N] {
    let mut tau = f64::NEG_INFINITY;
    for i in 0..N {
        tau = tau.max(radii[i] * p[i].abs() - excess[i]);
    }
    if tau < f64::MIN_POSITIVE {
        let flat = sums(radii, p, excess, 0.0).0;
        if flat <= 1.0 {
            return on_focal_set(radii, p, excess, flat);
        }
        tau = 0.0;
    }
    for _ in 0..MAX_STEPS {
        let (sum, slope) = sums(radii, p, excess, tau);
        let step = sum / slope * (sum.sqrt() - 1.0);
        if step <= f64::EPSILON * tau {
            break;
        }
        tau += step;
    }
    let mut n = p;
    for i in 0..N {
        n[i] = p[i] / (tau + excess[i]);
    }
    unit(n)
}

/// `sum w^2` and `sum w^2 / (tau + excess)` with `w = a p / (tau + excess)`; components that are zero on a pole count
/// as zero.
fn sums<const N: usize>(radii: [f64; N], p: [f64; N], excess: [f64; N], tau: f64) -> (f64, f64) {
    let (mut sum, mut slope) = (0.0, 0.0);
    for i in 0..N {
        let pole = tau + excess[i];
        if pole > 0.0 {
            let w = radii[i] * p[i] / pole;
            sum += w * w;
            slope += w * w / pole;
        }
    }
    (sum, slope)
}

/// The nearest (or farthest) point for a point on the focal set: the other components have `tau` at the pole, and the
/// remaining component is along the first shortest (or longest) axis, on the point's side, else on the positive one.
fn on_focal_set<const N: usize>(radii: [f64; N], p: [f64; N], excess: [f64; N], flat: f64) -> [f64; N] {
    let mut n = [0.0; N];
    let mut open = true;
    for i in 0..N {
        if excess[i] > 0.0 {
            n[i] = p[i] / excess[i];
        } else if open {
            open = false;
            n[i] = ((1.0 - flat).sqrt() / radii[i]).copysign(p[i] + 0.0);
        }
    }
    unit(n)
}

fn unit<const N: usize>(n: [f64; N]) -> [f64; N] {
    let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
    n.map(|c| c / length)
}
