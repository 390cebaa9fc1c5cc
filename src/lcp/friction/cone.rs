//! The friction cone of a contact and its dual: projection, ratio test, natural residual.
//!
//! A cone's numbers are its normal one and its two tangential ones, `[n, t1, t2]`; in the plane the second tangential
//! one is zero. A row alone is a cone without friction, whose tangential numbers are zero. Multipliers lie in
//! `K = { |t| <= mu n }`, gaps and slips in its dual `K* = { n >= mu |t| }`.

/// Numbers of a cone.
pub(super) type Triple = [f64; 3];

/// A point after a displacement to a point of the cone may lie outside by this part of its terms, by rounding.
pub(in crate::lcp) const ROUNDING: f64 = 1e-12;

/// The length of the tangential part.
#[inline]
pub(super) fn tangential(x: Triple) -> f64 {
    (x[1] * x[1] + x[2] * x[2]).sqrt()
}

#[inline]
pub(super) fn dot(x: Triple, y: Triple) -> f64 {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

/// Whether it lies in `K`.
#[inline]
pub(super) fn contains(x: Triple, mu: f64) -> bool {
    x[0] >= 0.0 && tangential(x) <= mu * x[0]
}

/// Whether it lies in `K*`.
#[inline]
pub(super) fn dual_contains(g: Triple, mu: f64) -> bool {
    mu * tangential(g) <= g[0]
}

/// The nearest point of `K`.
#[inline]
pub(super) fn project(x: Triple, mu: f64) -> Triple {
    let t = tangential(x);
    if x[0] >= 0.0 && t <= mu * x[0] {
        x
    } else if mu * t <= -x[0] {
        [0.0; 3]
    } else {
        let n = (x[0] + mu * t) / (1.0 + mu * mu);
        let part = mu * n / t;
        [n, part * x[1], part * x[2]]
    }
}

/// Numbers from elsewhere as multipliers: zeros where one is not finite, else the nearest ones.
pub(super) fn admit(x: Triple, mu: f64) -> Triple {
    if x.iter().all(|x| x.is_finite()) { project(x, mu) } else { [0.0; 3] }
}

/// A point is on the boundary if this part of its tangential number is its distance.
pub(in crate::lcp) const ON_BOUNDARY: f64 = 1e-12;

/// `y - x`, for both in `K`. Along the boundary its normal number is made from the tangential ones: a displacement much
/// smaller than the two would have little but their rounding across the boundary, where the gradient is steep.
#[inline]
pub(super) fn displacement(x: Triple, y: Triple, mu: f64) -> Triple {
    let d = std::array::from_fn(|i| y[i] - x[i]);
    let (from, to) = (tangential(x), tangential(y));
    let on = |n: f64, t: f64| t > 0.0 && mu * n - t <= ON_BOUNDARY * t;
    if mu > 0.0 && on(x[0], from) && on(y[0], to) {
        let rise = (2.0 * x[1] + d[1]) * d[1] + (2.0 * x[2] + d[2]) * d[2];
        [rise / ((from + to) * mu), d[1], d[2]]
    } else {
        d
    }
}

/// How far `x` is from a solution of `K contains x _|_ g in K*`: the move of a projected step, `|s x - P(s x - g)|`
/// with `s` a mean diagonal entry of `A`. A length, zero at solutions only, NaN if a number is.
#[inline]
pub(super) fn residual(x: Triple, g: Triple, mu: f64, s: f64) -> f64 {
    let scaled = x.map(|x| s * x);
    let nearest = project(std::array::from_fn(|i| scaled[i] - g[i]), mu);
    let moved: Triple = std::array::from_fn(|i| scaled[i] - nearest[i]);
    dot(moved, moved).sqrt()
}

/// The largest `t` with `x + t d` in `K`, for `x` in it; infinite if there is none. For a displacement to a point of
/// `K` at least 1: along the boundary rounding would give any number.
pub(super) fn room(x: Triple, d: Triple, mu: f64) -> f64 {
    let end: Triple = std::array::from_fn(|i| x[i] + d[i]);
    let (n, t) = (x[0].abs() + d[0].abs(), tangential(x) + tangential(d));
    let within = end[0] >= -ROUNDING * n && tangential(end) - mu * end[0] <= ROUNDING * (mu * n + t);
    let (from, passed) = if within { (end, 1.0) } else { (x, 0.0) };
    passed + first_root(from, d, mu)
}

/// The same of one row: the largest `t` for which `x + t d` is not negative.
#[inline]
pub(super) fn room_of_ray(x: f64, d: f64) -> f64 {
    let end = x + d;
    let within = end >= -ROUNDING * (x.abs() + d.abs());
    let (from, passed) = if within { (end, 1.0) } else { (x, 0.0) };
    if d < 0.0 { passed + (from / -d).max(0.0) } else { f64::INFINITY }
}

/// The first `t >= 0` at which `x + t d` leaves `K`, for `x` in it up to rounding.
fn first_root(x: Triple, d: Triple, mu: f64) -> f64 {
    let apex = if d[0] < 0.0 { (x[0] / -d[0]).max(0.0) } else { f64::INFINITY };
    let form = |x: Triple, y: Triple| mu * mu * x[0] * y[0] - (x[1] * y[1] + x[2] * y[2]);
    // `c + 2 b t + a t^2`, not negative inside.
    let (c, b, a) = (form(x, x).max(0.0), form(x, d), form(d, d));
    let discriminant = b * b - a * c;
    let root = if a < 0.0 {
        let sum = discriminant.max(0.0).sqrt() + b.abs();
        if b >= 0.0 { sum / -a } else { c / sum }
    } else if b < 0.0 && discriminant >= 0.0 {
        c / (discriminant.sqrt() - b)
    } else {
        f64::INFINITY
    };
    // An end at the apex may be a root that rounding hides.
    root.min(apex)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn triple(rng: &mut ChaCha8Rng) -> Triple {
        std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0)
    }

    #[test]
    fn a_projection_leaves_what_the_dual_cone_allows() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..10_000 {
            let (x, mu) = (triple(&mut rng), 10.0 * rng.random::<f64>());
            let near = project(x, mu);
            let left: Triple = std::array::from_fn(|i| near[i] - x[i]);
            assert!(tangential(near) <= mu * near[0] + 1e-15, "{x:?} {mu}");
            assert!(mu * tangential(left) <= left[0] + 1e-12, "{x:?} {mu}");
            assert!(dot(near, left).abs() < 1e-13, "{x:?} {mu}");
            assert!(residual(near, left, mu, 1.0) < 1e-12);
        }
    }

    #[test]
    fn cones_without_friction_are_rays() {
        for n in [-2.0, -0.0, 0.0, 2.0] {
            assert_eq!(project([n, 0.0, 0.0], 0.0)[0], f64::max(n, 0.0));
            assert_eq!(contains([n, 0.0, 0.0], 0.0), n >= 0.0);
        }
        assert_eq!(residual([2.0, 0.0, 0.0], [-0.25, 0.0, 0.0], 0.0, 2.0), 0.25);
        assert_eq!(project([2.0, 1.0, -3.0], 0.0), [2.0, 0.0, 0.0]);
        assert_eq!(project([-2.0, 1.0, -3.0], 0.0), [0.0; 3]);
        assert_eq!(residual([0.5, 0.0, 0.0], [0.0, 7.0, 1.0], 0.0, 2.0), 0.0);
        assert_eq!(residual([0.5, 0.0, 0.0], [3.0, 7.0, 1.0], 0.0, 2.0), 1.0);
        assert_eq!(room([1.0, 0.0, 0.0], [-0.5, 0.0, 0.0], 0.0), 2.0);
        assert_eq!(room([1.0, 0.0, 0.0], [-2.0, 0.0, 0.0], 0.0), 0.5);
    }

    #[test]
    fn what_is_no_number_is_not_hidden_and_not_admitted() {
        for place in 0..3 {
            let mut x = [1.0; 3];
            x[place] = f64::NAN;
            assert!(residual(x, [0.0; 3], 0.5, 1.0).is_nan());
            assert!(residual([0.0; 3], x, 0.5, 1.0).is_nan());
            assert_eq!(admit(x, 0.5), [0.0; 3]);
        }
        assert_eq!(admit([-1.0, 0.1, 0.0], 0.5), [0.0; 3]);
    }

    #[test]
    fn the_room_ends_at_the_boundary() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..10_000 {
            let mu = 3.0 * rng.random::<f64>();
            let (x, d) = (project(triple(&mut rng), mu), triple(&mut rng));
            let at = |t: f64| std::array::from_fn(|i| x[i] + t * d[i]);
            let outside = |x: Triple| tangential(x) - mu * x[0];
            let end = room(x, d, mu);
            if end.is_finite() {
                assert!(outside(at(end)).abs() < 1e-9, "{x:?} {d:?} {mu} {end}");
                assert!(outside(at(end + 1e-3)) > 0.0, "{x:?} {d:?} {mu} {end}");
            }
            for part in [0.0, 0.3, 0.9, 1.0] {
                assert!(outside(at(part * end.min(50.0))) < 1e-9, "{x:?} {d:?} {mu} {end}");
            }
        }
    }

    #[test]
    fn small_displacements_along_the_boundary_stay_on_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for _ in 0..1_000 {
            let mu = 0.1 + rng.random::<f64>();
            let on = |t: [f64; 2]| [t[0].hypot(t[1]) / mu, t[0], t[1]];
            let [_, a, b] = triple(&mut rng);
            let x = on([a, b]);
            let y = on([a + 1e-9 * rng.random::<f64>(), b + 1e-9 * rng.random::<f64>()]);
            let d = displacement(x, y, mu);
            assert!((0..3).all(|i| (d[i] - (y[i] - x[i])).abs() <= 1e-14), "{d:?}");
            // Across the boundary, to second order.
            let across = mu * mu * x[0] * d[0] - x[1] * d[1] - x[2] * d[2];
            assert!(across.abs() <= 1e-17, "{across:e}");
        }
        assert_eq!(displacement([1.0, 0.1, 0.0], [2.0, 0.0, 0.3], 0.5), [1.0, -0.1, 0.3]);
    }

    #[test]
    fn a_displacement_within_the_cone_has_room() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for case in 0..10_000 {
            let mu = 3.0 * rng.random::<f64>();
            let (x, mut y) = (project(triple(&mut rng), mu), project(triple(&mut rng), mu));
            if case % 3 == 0 {
                // Along the boundary.
                y = x.map(|x| 1.7 * x);
            }
            let d = std::array::from_fn(|i| y[i] - x[i]);
            assert!(room(x, d, mu) >= 1.0, "{x:?} {d:?} {mu}");
        }
        assert_eq!(room([2.0, 0.0, 0.0], [-2.0, 0.0, 0.0], 0.5), 1.0);
        assert_eq!(room([2.0, 1.0, 0.0], [2.0, 0.0, 0.0], 0.5), f64::INFINITY);
    }
}
