//! Where a line first meets a custom shape.
//!
//! In a normal that faces the line's start, scaled to `w - d` with `w` at right angles to the line's direction `d`, the body's tangent plane is crossed at
//! `t(w) = (w - d) . o - h(w - d)`. The line is outside before every such plane, and `t` is concave in `w`, so that its maximum over the plane of `w` is the
//! first hit: Newton's method with steps that are halved until they gain. A line that misses has planes as far along it as one likes; it is given up
//! where it has passed the bounding sphere.

use crate::shape::Convex;
use glam::DVec3;

/// Steps at most; a line that touches the body takes MEASURE.
const STEPS: usize = 100;
/// Gain in `t`, as a part of the bounding radius, that is rounding.
const GAIN: f64 = 1e-14;
/// Step of the central differences, as a part of the normal's length.
const DIFFERENCE: f64 = 1e-5;

/// The least `t` for which `origin + t * direction` (a unit vector) lies on the surface; `None` where the line misses.
pub(super) fn first_hit(shape: Convex, origin: DVec3, direction: DVec3) -> Option<f64> {
    let radius = shape.bounding_radius();
    let along = origin.dot(direction);
    let o = origin - direction * along;
    let left = radius * radius - o.length_squared();
    if left < 0.0 {
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
    /// Its point nearest to the body's centre.
    o: DVec3,
    direction: DVec3,
    basis: (DVec3, DVec3),
}

/// A tangent plane: its `w`, where it is crossed, and the body's point.
struct Plane {
    w: DVec3,
    t: f64,
    point: DVec3,
}

impl Line {
    fn point(&self, w: DVec3) -> DVec3 {
        self.shape.point((w - self.direction).normalize())
    }

    fn plane(&self, w: DVec3) -> Plane {
        let point = self.point(w);
        Plane { w, t: (w - self.direction).dot(self.o - point), point }
    }

    /// The plane after a step of Newton's method; none where no step gains more than `least`.
    fn better(&self, at: &Plane, least: f64) -> Option<Plane> {
        let (e1, e2) = self.basis;
        let gap = self.o - at.point;
        let (g1, g2) = (gap.dot(e1), gap.dot(e2));
        let step = DIFFERENCE * (at.w - self.direction).length();
        let change = |e: DVec3| (self.point(at.w + e * step) - self.point(at.w - e * step)) / (2.0 * step);
        let (along_1, along_2) = (change(e1), change(e2));
        let (h11, h12, h22) = (along_1.dot(e1), 0.5 * (along_1.dot(e2) + along_2.dot(e1)), along_2.dot(e2));
        let determinant = h11 * h22 - h12 * h12;
        let (mut s1, mut s2) = ((h22 * g1 - h12 * g2) / determinant, (h11 * g2 - h12 * g1) / determinant);
        // Where rounding leaves no curvature, straight up.
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
