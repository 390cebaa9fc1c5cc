//! The first intersection of a line with a body, by family of shapes, and the reach of a body in a direction.
//!
//! Everything is in body axes and in closed form, except superellipsoids (`gauge_hit`), custom shapes (`convex_hit`)
//! and the circle, whose surface is of fourth degree: `(|p|^2 + R^2 - r^2)^2 = 4 R^2 (x^2 + y^2)`. Along a line
//! measured from its point nearest to the centre that is a quartic without a cubic term, so its second derivative has
//! two opposite roots or none; between them it is concave and outside them convex, and in each of the three parts
//! Newton's iteration from the right end is monotone.

use super::{convex_hit, gauge_hit};
use crate::separation::point_to_convex;
use crate::shape::{Centreline, Geometry};
use glam::DVec3;

/// Newton steps on the quartic. Convergence is quadratic except at a tangent line, where each step halves the error: 60
/// halvings exhaust the 53 bits of an `f64`.
const NEWTON_STEPS: usize = 60;

/// The least `t` for which `origin + t * direction` (a unit vector) lies on the surface; `None` if the line misses.
pub(super) fn first_hit(geometry: &Geometry, origin: DVec3, direction: DVec3) -> Option<f64> {
    match *geometry {
        Geometry::Centreline { curve: Centreline::Point, radius } => point(radius, origin, direction),
        Geometry::Centreline { curve: Centreline::Segment { half }, radius } => {
            segment(half, radius, origin, direction)
        }
        Geometry::Centreline { curve: Centreline::Circle { radius: major }, radius } => {
            circle(major, radius, origin, direction)
        }
        Geometry::Ellipsoid { radii } => ellipsoid(radii, origin, direction),
        Geometry::Convex(shape) => match shape.norm() {
            Some(norm) => gauge_hit::first_hit(norm, origin, direction),
            None => convex_hit::first_hit(shape, origin, direction),
        },
    }
}

/// The outward unit normal at a point of the surface.
pub(super) fn normal(geometry: &Geometry, point: DVec3) -> DVec3 {
    match *geometry {
        Geometry::Centreline { curve, .. } => {
            let foot = match curve {
                Centreline::Point => DVec3::ZERO,
                Centreline::Segment { half } => DVec3::Z * point.z.clamp(-half, half),
                Centreline::Circle { radius } => DVec3::new(point.x, point.y, 0.0).normalize_or_zero() * radius,
            };
            (point - foot).normalize_or_zero()
        }
        Geometry::Ellipsoid { radii } => (point / (radii * radii)).normalize_or_zero(),
        Geometry::Convex(shape) => match shape.norm() {
            Some(norm) => norm.gauge(point).1.normalize_or_zero(),
            None => point_to_convex(shape, point).1,
        },
    }
}

/// The larger reach of the body from its centre along a unit vector or its opposite.
pub(super) fn reach(geometry: &Geometry, direction: DVec3) -> f64 {
    match *geometry {
        Geometry::Centreline { curve, radius } => {
            radius
                + match curve {
                    Centreline::Point => 0.0,
                    Centreline::Segment { half } => half * direction.z.abs(),
                    Centreline::Circle { radius } => radius * direction.truncate().length(),
                }
        }
        Geometry::Ellipsoid { radii } => (radii * direction).length(),
        Geometry::Convex(shape) => shape.reach(direction).max(shape.reach(-direction)),
    }
}

fn point(radius: f64, origin: DVec3, direction: DVec3) -> Option<f64> {
    let along = origin.dot(direction);
    let discriminant = radius * radius - (origin - direction * along).length_squared();
    (discriminant >= 0.0).then(|| -along - discriminant.sqrt())
}

/// A line enters through the side if it enters the infinite cylinder between the ends, otherwise through the cap on the
/// side of that entry: beyond an end, the body's cross-section is inside the cylinder's.
fn segment(half: f64, radius: f64, origin: DVec3, direction: DVec3) -> Option<f64> {
    let (o, d) = (origin.truncate(), direction.truncate());
    let square = d.length_squared();
    // The line's moment about the axis keeps the discriminant accurate if `square` is small.
    let discriminant = square * radius * radius - o.perp_dot(d).powi(2);
    if square > 0.0 && discriminant < 0.0 {
        return None;
    }
    let end = if square > 0.0 {
        let t = (-o.dot(d) - discriminant.sqrt()) / square;
        let z = origin.z + t * direction.z;
        if z.abs() <= half {
            return Some(t);
        }
        half.copysign(z)
    } else {
        // Along the axis: the cap that faces the line.
        half.copysign(-direction.z)
    };
    point(radius, origin - DVec3::Z * end, direction)
}

fn ellipsoid(radii: DVec3, origin: DVec3, direction: DVec3) -> Option<f64> {
    let (o, d) = (origin / radii, direction / radii);
    let square = d.length_squared();
    let discriminant = square - o.cross(d).length_squared();
    (discriminant >= 0.0).then(|| (-o.dot(d) - discriminant.sqrt()) / square)
}

fn circle(major: f64, radius: f64, origin: DVec3, direction: DVec3) -> Option<f64> {
    let along = origin.dot(direction);
    let o = origin - direction * along;
    let (square, outer) = (o.length_squared(), major + radius);
    if square > outer * outer {
        return None;
    }
    let (major2, flat) = (major * major, direction.truncate().length_squared());
    let k = square + major2 - radius * radius;
    let quartic = Quartic {
        c2: 2.0 * (k - 2.0 * major2 * flat),
        c1: 8.0 * major2 * o.z * direction.z,
        c0: k * k - 4.0 * major2 * o.truncate().length_squared(),
    };
    quartic.least_root_from(-(outer * outer - square).sqrt()).map(|t| t - along)
}

/// `t^4 + c2 t^2 + c1 t + c0`.
struct Quartic {
    c2: f64,
    c1: f64,
    c0: f64,
}

impl Quartic {
    fn value(&self, t: f64) -> f64 {
        ((t * t + self.c2) * t + self.c1) * t + self.c0
    }

    fn slope(&self, t: f64) -> f64 {
        (4.0 * t * t + 2.0 * self.c2) * t + self.c1
    }

    /// The least root, given a `start` at or before it.
    fn least_root_from(&self, start: f64) -> Option<f64> {
        if self.c2 >= 0.0 {
            return self.convex_root(start, f64::INFINITY);
        }
        let bend = (-self.c2 / 6.0).sqrt();
        if start < -bend
            && let Some(root) = self.convex_root(start, -bend)
        {
            return Some(root);
        }
        // Positive at the left end of the concave part (or at `start`): a root in it shows as a value below zero at
        // its right end.
        if start < bend && self.value(bend) <= 0.0 {
            return Some(self.newton(bend));
        }
        self.convex_root(start.max(bend), f64::INFINITY)
    }

    /// The least root in a convex part from `start` to `end`, with no root before `start`.
    fn convex_root(&self, start: f64, end: f64) -> Option<f64> {
        let mut t = start;
        for _ in 0..NEWTON_STEPS {
            let (value, slope) = (self.value(t), self.slope(t));
            if value <= 0.0 {
                return Some(t);
            }
            let next = t - value / slope;
            // A rising slope: the minimum is behind and was positive. NaN: no root.
            if slope >= 0.0 || next.is_nan() || next > end {
                return None;
            }
            if next == t {
                break;
            }
            t = next;
        }
        Some(t)
    }

    /// The root before `start` in a concave part that ends at `start`, with a value of at most zero there.
    fn newton(&self, start: f64) -> f64 {
        let mut t = start;
        for _ in 0..NEWTON_STEPS {
            let next = t - self.value(t) / self.slope(t);
            if next.is_nan() || next >= t {
                break;
            }
            t = next;
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Zero on the surface, positive outside; a distance for the thickened curves.
    fn implicit(geometry: &Geometry, p: DVec3) -> f64 {
        match *geometry {
            Geometry::Centreline { curve: Centreline::Point, radius } => p.length() - radius,
            Geometry::Centreline { curve: Centreline::Segment { half }, radius } => {
                (p - DVec3::Z * p.z.clamp(-half, half)).length() - radius
            }
            Geometry::Centreline { curve: Centreline::Circle { radius: major }, radius } => {
                (p.truncate().length() - major).hypot(p.z) - radius
            }
            Geometry::Ellipsoid { radii } => (p / radii).length() - 1.0,
            Geometry::Convex(shape) => point_to_convex(shape, p).0,
        }
    }

    fn geometries() -> [Geometry; 8] {
        let centreline = |curve, radius| Geometry::Centreline { curve, radius };
        [
            centreline(Centreline::Point, 1.3),
            centreline(Centreline::Segment { half: 1.7 }, 0.5),
            centreline(Centreline::Segment { half: 0.0 }, 0.5),
            centreline(Centreline::Circle { radius: 1.5 }, 0.4),
            centreline(Centreline::Circle { radius: 2.0 }, 0.02),
            centreline(Centreline::Circle { radius: 1.0 }, 0.999),
            Geometry::Ellipsoid { radii: DVec3::new(0.5, 0.8, 2.0) },
            Geometry::Ellipsoid { radii: DVec3::new(2.0, 0.05, 1.0) },
        ]
    }

    fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
        loop {
            let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// Lines through points near the body, every third one along an axis or in an axis plane.
    fn line(rng: &mut ChaCha8Rng, k: usize) -> (DVec3, DVec3) {
        let mut direction = unit(rng);
        match k % 9 {
            0 => direction = DVec3::AXES[k / 9 % 3],
            3 => direction = direction.with_z(0.0).normalize(),
            6 => direction = direction.with_x(0.0).normalize(),
            _ => {}
        }
        let through = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-2.2..2.2)));
        (through + direction * rng.random_range(-5.0..5.0), direction)
    }

    #[test]
    fn hits_lie_on_the_surface_and_nothing_lies_before_them() {
        for (g, geometry) in geometries().iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(g as u64);
            let (mut hits, mut misses) = (0, 0);
            for k in 0..4000 {
                let (origin, direction) = line(&mut rng, k);
                let hit = first_hit(geometry, origin, direction);
                let nearest = -origin.dot(direction);
                let end = match hit {
                    Some(t) => {
                        let p = origin + direction * t;
                        let off = implicit(geometry, p).abs();
                        assert!(off < 1e-9, "geometry {g}, line {k}: {off:e} off the surface");
                        assert!(normal(geometry, p).dot(direction) < 1e-6, "geometry {g}, line {k}: hit from inside");
                        hits += 1;
                        t
                    }
                    None => {
                        misses += 1;
                        nearest + 4.0
                    }
                };
                let start = nearest - 4.0;
                for step in 0..1000 {
                    let t = start + (end - start) * f64::from(step) / 1000.0;
                    let inside = implicit(geometry, origin + direction * t);
                    assert!(inside > -1e-9, "geometry {g}, line {k}: {inside:e} at {t}, but {hit:?}");
                }
            }
            assert!(hits > 50 && misses > 50, "geometry {g}: {hits} hits, {misses} misses");
        }
    }

    #[test]
    fn the_normal_is_the_gradient() {
        for (g, geometry) in geometries().iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(g as u64);
            for k in 0..300 {
                let (origin, direction) = line(&mut rng, k);
                let Some(t) = first_hit(geometry, origin, direction) else { continue };
                let (p, h) = (origin + direction * t, 1e-6);
                let slope = |e: DVec3| implicit(geometry, p + e * h) - implicit(geometry, p - e * h);
                let gradient = DVec3::from_array(DVec3::AXES.map(slope)).normalize();
                assert!(gradient.distance(normal(geometry, p)) < 1e-3, "geometry {g}, line {k}");
            }
        }
    }

    /// No hit lies beyond the reach, and at least one comes near it.
    #[test]
    fn reach_is_the_support_function() {
        for (g, geometry) in geometries().iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(g as u64);
            let points: Vec<DVec3> = (0..20_000)
                .filter_map(|k| {
                    let (origin, direction) = line(&mut rng, k);
                    first_hit(geometry, origin, direction).map(|t| origin + direction * t)
                })
                .collect();
            for _ in 0..20 {
                let e = unit(&mut rng);
                let farthest = points.iter().map(|p| p.dot(e)).fold(0.0, f64::max);
                let reach = reach(geometry, e);
                assert!(farthest < reach + 1e-9 && farthest > 0.9 * reach, "geometry {g}: {farthest} of {reach}");
            }
        }
    }

    #[test]
    fn numbers_that_are_not_finite_do_not_panic() {
        for geometry in geometries() {
            for bad in [f64::NAN, f64::INFINITY, 1e300] {
                first_hit(&geometry, DVec3::new(bad, 0.0, 0.1), DVec3::Z);
                first_hit(&geometry, DVec3::ZERO, DVec3::new(0.0, bad, 1.0));
            }
        }
    }
}
