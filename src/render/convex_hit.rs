//! The first intersection of a line with a custom shape.
//!
//! In a normal that faces the line's start, scaled to `w - d` with `w` at right angles to the line's direction `d`, the
//! body's tangent plane is crossed at `t(w) = (w - d) . o - h(w - d)`. The line is outside before every such plane, and
//! `t` is concave in `w`, so that its maximum over the plane of `w` is the first hit. Newton's method finds it, with
//! steps that are halved until `t` grows. For a line that misses, `t` is unbounded; the search ends when `t` passes the
//! bounding sphere. Hits are exact to 1e-9 of the size, to 1e-6 on bodies with points of zero curvature.

use crate::shape::Convex;
use glam::DVec3;

/// The largest number of steps; of 9,000 lines, including misses, none took more than 14, at aspect ratios up to 40.
const STEPS: usize = 100;
/// A gain in `t` below this part of the bounding radius is rounding.
const GAIN: f64 = 1e-14;

/// The least `t` for which `origin + t * direction` (a unit vector) lies on the surface; `None` if the line misses.
pub(super) fn first_hit(shape: Convex, origin: DVec3, direction: DVec3) -> Option<f64> {
    let radius = shape.bounding_radius();
    let along = origin.dot(direction);
    let o = origin - direction * along;
    let left = radius * radius - o.length_squared();
    if left.is_nan() || left < 0.0 {
        return None;
    }
    let line = Line { shape, o, direction, basis: direction.any_orthonormal_pair() };
    let mut at = line.plane(DVec3::ZERO);
    for _ in 0..STEPS {
        if at.t > left.sqrt() {
            return None;
        }
        let Some(next) = line.better(&at, GAIN * radius) else { break };
        at = next;
    }
    Some(at.t - along)
}

struct Line {
    shape: Convex,
    /// The line's point nearest to the body's centre.
    o: DVec3,
    direction: DVec3,
    basis: (DVec3, DVec3),
}

/// A tangent plane: its `w`, its intersection `t`, and the body's point.
struct Plane {
    w: DVec3,
    t: f64,
    point: DVec3,
}

impl Line {
    fn plane(&self, w: DVec3) -> Plane {
        let point = self.shape.point((w - self.direction).normalize());
        Plane { w, t: (w - self.direction).dot(self.o - point), point }
    }

    /// The plane after a step of Newton's method; none if no step gains more than `least`.
    fn better(&self, at: &Plane, least: f64) -> Option<Plane> {
        let (e1, e2) = self.basis;
        let gap = self.o - at.point;
        let (g1, g2) = (gap.dot(e1), gap.dot(e2));
        // The Hessian in `w` is that across the normal, seen in the basis of `w` and divided by the normal's length.
        let length = (at.w - self.direction).length();
        let normal = (at.w - self.direction) / length;
        let tangents = normal.any_orthonormal_pair();
        let (k11, k12, k22) = self.shape.hessian(normal, tangents);
        let seen = |e: DVec3| (e.dot(tangents.0), e.dot(tangents.1));
        let form =
            |a: (f64, f64), b: (f64, f64)| (k11 * a.0 * b.0 + k12 * (a.0 * b.1 + a.1 * b.0) + k22 * a.1 * b.1) / length;
        let (a1, a2) = (seen(e1), seen(e2));
        let (h11, h12, h22) = (form(a1, a1), form(a1, a2), form(a2, a2));
        let determinant = h11 * h22 - h12 * h12;
        let (mut s1, mut s2) = ((h22 * g1 - h12 * g2) / determinant, (h11 * g2 - h12 * g1) / determinant);
        // If rounding hides the curvature, along the gradient.
        if !(determinant > 0.0 && s1 * g1 + s2 * g2 > 0.0) {
            (s1, s2) = (g1 / self.shape.bounding_radius(), g2 / self.shape.bounding_radius());
        }
        while s1 * g1 + s2 * g2 > least {
            let next = self.plane(at.w + e1 * s1 + e2 * s2);
            if next.t > at.t {
                return Some(next);
            }
            (s1, s2) = (0.5 * s1, 0.5 * s2);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::intersect;
    use super::*;
    use crate::separation::point_to_convex;
    use crate::shape::Geometry;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn ellipsoid(radii: DVec3, n: DVec3) -> DVec3 {
        radii * radii * n / (radii * n).length()
    }

    fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
        loop {
            let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    #[test]
    fn a_line_meets_a_custom_ellipsoid_where_it_meets_the_ellipsoid() {
        let mut rng = ChaCha8Rng::seed_from_u64(41);
        for radii in [[1.0, 1.0, 1.0], [0.5, 0.8, 2.0], [2.0, 0.05, 1.0]].map(DVec3::from_array) {
            let shape = Convex::new(move |n: DVec3| ellipsoid(radii, n)).unwrap();
            let (mut hits, mut misses) = (0, 0);
            for k in 0..3000 {
                let direction = if k % 5 == 0 { DVec3::AXES[k % 3] } else { unit(&mut rng) };
                let origin = 1.8 * radii.max_element() * rng.random_range(0.0..1.0) * unit(&mut rng);
                let own = Geometry::Ellipsoid { radii };
                let grazing = (
                    intersect::first_hit(&own, origin * 1.00001, direction).is_some(),
                    intersect::first_hit(&own, origin * 0.99999, direction).is_some(),
                );
                match (first_hit(shape, origin, direction), intersect::first_hit(&own, origin, direction)) {
                    (Some(t), Some(expected)) => {
                        // A grazing line is nearly parallel to the surface: there `t` is exact only to the root of
                        // rounding.
                        let point = origin + expected * direction;
                        let steep = intersect::normal(&own, point).dot(direction).abs();
                        assert!((t - expected).abs() * steep < 1e-9, "{radii} {origin} {direction}: {t} {expected}");
                        let normal = intersect::normal(&Geometry::Convex(shape), point);
                        assert!(normal.distance(intersect::normal(&own, point)) < 1e-6, "{radii} {point} {normal}");
                        hits += 1;
                    }
                    (None, None) => misses += 1,
                    (found, expected) => {
                        assert!(grazing.0 != grazing.1, "{radii} {origin} {direction}: {found:?} {expected:?}")
                    }
                }
            }
            assert!(hits > 300 && misses > 300, "{radii}: {hits} hits, {misses} misses");
        }
    }

    #[test]
    fn other_bodies_are_met_where_they_are() {
        // An egg with one end blunter.
        let blunt = |n: DVec3| {
            let cubic = 0.06 * (3.0 * n.z * n.z * DVec3::Z - 2.0 * n.z.powi(3) * n);
            ellipsoid(DVec3::new(1.0, 1.0, 1.3), n) + cubic - 0.030510133683 * DVec3::Z
        };
        // And `x^4 + y^4 + z^4 = 1`, which has no curvature on the axes.
        let superball =
            |n: DVec3| n.signum() * n.abs().powf(1.0 / 3.0) / n.abs().powf(4.0 / 3.0).element_sum().powf(0.25);
        is_met_where_it_is(Convex::new(blunt).unwrap(), 1e-9);
        is_met_where_it_is(Convex::new(superball).unwrap(), 1e-6);
    }

    /// Each hit is on the surface and the line is outside before it; a line that misses is outside everywhere.
    fn is_met_where_it_is(shape: Convex, known: f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(42);
        let mut counts = [0; 2];
        for _ in 0..1000 {
            let (origin, direction) = (1.5 * rng.random_range(0.0..1.0) * unit(&mut rng), unit(&mut rng));
            let hit = first_hit(shape, origin, direction);
            let gap = |t: f64| point_to_convex(shape, origin + t * direction).0;
            let nearest = -origin.dot(direction);
            if let Some(t) = hit {
                assert!(gap(t).abs() < known, "{origin} {direction}: {}", gap(t));
            }
            let end = hit.unwrap_or(nearest + 2.0);
            let least =
                (0..=40).map(|k| gap(nearest - 2.0 + (end - nearest + 2.0) * f64::from(k) / 40.0)).fold(1.0, f64::min);
            assert!(least > -known, "{origin} {direction} {hit:?}: {least}");
            counts[usize::from(hit.is_some())] += 1;
        }
        assert!(counts[0] >= 50 && counts[1] >= 50, "{counts:?}");
    }

    #[test]
    fn numbers_that_are_not_finite_do_not_panic() {
        let shape = Convex::new(|n: DVec3| n).unwrap();
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(first_hit(shape, DVec3::new(bad, 0.0, 0.1), DVec3::Z), None);
            first_hit(shape, DVec3::ZERO, DVec3::new(0.0, bad, 1.0));
        }
    }
}
