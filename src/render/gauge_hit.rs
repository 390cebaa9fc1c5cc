//! The first intersection of a line with a superellipsoid.
//!
//! Along a line the gauge is convex, so that Newton's iteration from where the line enters the box around the body is
//! monotone, up to the first point of the surface. On a line that misses the gauge stays over 1, and begins to grow
//! before the line leaves the box.

use crate::shape::Norm;
use glam::DVec3;

/// The largest number of steps. Convergence is quadratic except at a tangent line, where each step halves the error: 60
/// halvings exhaust the 53 bits of an `f64`.
const STEPS: usize = 60;

/// The least `t` for which `origin + t * direction` (a unit vector) lies on the surface; `None` if the line misses.
pub(super) fn first_hit(norm: &Norm, origin: DVec3, direction: DVec3) -> Option<f64> {
    let (mut t, end) = within(norm.half_widths(), origin, direction)?;
    for _ in 0..STEPS {
        let (gauge, gradient) = norm.gauge(origin + direction * t);
        let slope = gradient.dot(direction);
        if gauge <= 1.0 {
            break;
        }
        let next = t - (gauge - 1.0) / slope;
        if slope >= 0.0 || next > end || next.is_nan() {
            return None;
        }
        if next <= t {
            break;
        }
        t = next;
    }
    Some(t)
}

/// Where a line enters and leaves a box; `None` if it does not, or is not finite.
fn within(half_widths: DVec3, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let (mut start, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
    for ((o, d), half) in origin.to_array().into_iter().zip(direction.to_array()).zip(half_widths.to_array()) {
        if d == 0.0 {
            if o.abs() > half {
                return None;
            }
            continue;
        }
        let (near, far) = ((-half.copysign(d) - o) / d, (half.copysign(d) - o) / d);
        start = start.max(near);
        end = end.min(far);
    }
    (start <= end && start.is_finite() && end.is_finite()).then_some((start, end))
}

#[cfg(test)]
mod tests {
    use super::super::{convex_hit, intersect};
    use super::*;
    use crate::separation::point_to_convex;
    use crate::shape::{Convex, Geometry, Shape, Superellipsoid};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn convex(radii: [f64; 3], exponents: [f64; 2]) -> Convex {
        match Shape::Superellipsoid(Superellipsoid::new(radii, exponents)).geometry() {
            Geometry::Convex(convex) => convex,
            other => panic!("{other:?}"),
        }
    }

    fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
        loop {
            let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// A line past a body of this size; of five, one along an axis and one in an axis plane.
    fn line(k: usize, size: f64, rng: &mut ChaCha8Rng) -> (DVec3, DVec3) {
        let direction = match k % 5 {
            0 => DVec3::AXES[k / 5 % 3],
            1 => unit(rng).with_y(0.0).normalize(),
            _ => unit(rng),
        };
        let past = 1.1 * size * rng.random_range(0.0..1.0) * unit(rng);
        (past + direction * (size * rng.random_range(-5.0..5.0)), direction)
    }

    const BODIES: [([f64; 3], [f64; 2]); 6] = [
        ([1.0; 3], [2.5; 2]),
        ([0.5, 1.0, 2.0], [4.0, 3.0]),
        ([1.0, 0.7, 1.5], [8.0; 2]),
        ([1.0, 2.0, 0.1], [10.0; 2]),
        ([1.0, 1.0, 30.0], [2.0, 10.0]),
        ([3.0, 0.5, 1.0], [10.0, 2.0]),
    ];

    /// The point and the normal are those that the search for the highest tangent plane, and for the nearest point of
    /// the surface, find.
    #[test]
    fn a_line_meets_a_superellipsoid_where_the_search_meets_it() {
        let (radii, exponents) = BODIES[0];
        let mut rng = ChaCha8Rng::seed_from_u64(43);
        let shape = convex(radii, exponents);
        let size = shape.bounding_radius();
        let (mut hits, mut misses) = (0, 0);
        for k in 0..2000 {
            let (origin, direction) = line(k, size, &mut rng);
            let found = first_hit(shape.norm().unwrap(), origin, direction);
            match (found, convex_hit::first_hit(shape, origin, direction)) {
                (Some(t), Some(expected)) => {
                    let point = origin + direction * t;
                    let normal = intersect::normal(&Geometry::Convex(shape), point);
                    let (gap, searched) = point_to_convex(shape, point);
                    // A grazing line is nearly parallel to the surface.
                    let off = (t - expected).abs() * normal.dot(direction).abs();
                    assert!(off < 1e-6 * size, "{radii:?} {exponents:?}, line {k}: {t} {expected}");
                    assert!(gap.abs() < 1e-12 * size, "{radii:?} {exponents:?}, line {k}: {gap:e}");
                    let angle = normal.distance(searched);
                    assert!(angle < 1e-5, "{radii:?} {exponents:?}, line {k}: {normal} {searched}");
                    hits += 1;
                }
                (None, None) => misses += 1,
                (found, expected) => {
                    let at = origin + direction * found.or(expected).unwrap();
                    let grazing = intersect::normal(&Geometry::Convex(shape), at).dot(direction).abs();
                    assert!(grazing < 1e-3, "{radii:?} {exponents:?}, line {k}: {found:?} {expected:?}");
                }
            }
        }
        assert!(hits > 1000 && misses > 50, "{radii:?}: {hits} hits, {misses} misses");
    }

    /// By the inequality as it is written: outside before the hit, on the surface there, outside all along a miss.
    #[test]
    fn nothing_of_the_body_is_before_the_hit() {
        for (radii, exponents) in BODIES {
            let mut rng = ChaCha8Rng::seed_from_u64(44);
            let [n1, n2] = exponents;
            let left = |p: DVec3| {
                let v = (p / DVec3::from_array(radii)).abs();
                (v.x.powf(n2) + v.y.powf(n2)).powf(n1 / n2) + v.z.powf(n1)
            };
            let shape = convex(radii, exponents);
            let size = shape.bounding_radius();
            for k in 0..500 {
                let (origin, direction) = line(k, size, &mut rng);
                let hit = first_hit(shape.norm().unwrap(), origin, direction);
                let middle = -origin.dot(direction);
                if let Some(t) = hit {
                    let off = (left(origin + direction * t) - 1.0).abs();
                    assert!(off < 1e-10, "{radii:?} {exponents:?}, line {k}: {off:e}");
                }
                let (start, end) = (middle - 1.5 * size, hit.unwrap_or(middle + 1.5 * size));
                for step in 0..400 {
                    let t = start + (end - start) * f64::from(step) / 400.0;
                    let inside = left(origin + direction * t) - 1.0;
                    assert!(inside > -1e-10, "{radii:?} {exponents:?}, line {k}: {inside:e} at {t}, but {hit:?}");
                }
            }
        }
    }

    #[test]
    fn with_exponents_of_two_it_is_the_ellipsoid() {
        let mut rng = ChaCha8Rng::seed_from_u64(45);
        for radii in [[1.0; 3], [0.5, 0.8, 2.0], [2.0, 0.05, 1.0]] {
            let shape = convex(radii, [2.0; 2]);
            let own = Geometry::Ellipsoid { radii: DVec3::from_array(radii) };
            for k in 0..1000 {
                let (origin, direction) = line(k, shape.bounding_radius(), &mut rng);
                let found = intersect::first_hit(&Geometry::Convex(shape), origin, direction);
                let Some(expected) = intersect::first_hit(&own, origin, direction) else {
                    assert_eq!(found, None, "{radii:?}, line {k}");
                    continue;
                };
                let (at, normal) =
                    (origin + direction * expected, intersect::normal(&own, origin + direction * expected));
                let off = found.map_or(f64::INFINITY, |t| (t - expected).abs()) * normal.dot(direction).abs();
                assert!(off < 1e-12, "{radii:?}, line {k}: {found:?} {expected}");
                assert!(
                    intersect::normal(&Geometry::Convex(shape), at).distance(normal) < 1e-12,
                    "{radii:?}, line {k}"
                );
            }
        }
    }

    #[test]
    fn numbers_that_are_not_finite_do_not_panic() {
        let shape = convex([1.0; 3], [4.0; 2]);
        let norm = shape.norm().unwrap();
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(first_hit(norm, DVec3::new(bad, 0.0, 0.1), DVec3::Z), None);
            first_hit(norm, DVec3::ZERO, DVec3::new(0.0, bad, 1.0));
            first_hit(norm, DVec3::splat(bad), DVec3::splat(bad));
        }
    }
}
