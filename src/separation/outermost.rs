//! The distance from a point to the farthest point of a body.

use super::farthest_of_convex;
use crate::shape::{Centreline, Geometry, Shape};
use glam::{DQuat, DVec3};

/// The distance from `from` to the body's farthest point.
pub(crate) fn farthest(shape: &Shape, position: DVec3, orientation: DQuat, from: DVec3) -> f64 {
    let from = orientation.inverse() * (from - position);
    match shape.geometry() {
        Geometry::Centreline { curve, radius } => {
            radius
                + match curve {
                    Centreline::Point => from.length(),
                    Centreline::Segment { half } => DVec3::new(from.x, from.y, from.z.abs() + half).length(),
                    Centreline::Circle { radius } => (from.truncate().length() + radius).hypot(from.z),
                }
        }
        Geometry::Ellipsoid { radii } => farthest_of_ellipsoid(radii, from),
        Geometry::Convex(shape) => farthest_of_convex(shape, from),
    }
}

/// Halvings of the multiplier's range: more than the bits of a number.
const HALVINGS: usize = 100;

/// By Lagrange's multiplier: the farthest point `p` has `p - from = (a^2 + m) p / radii^2` with the longest radius `a`
/// and `m >= 0`, and `p` is on the ellipsoid for exactly one `m`. Along the longest axes `p` follows from the other
/// components, so that it is on the ellipsoid even if `from` has no component along them and `m` is 0.
fn farthest_of_ellipsoid(radii: DVec3, from: DVec3) -> f64 {
    let longest = radii.max_element();
    let gap = (DVec3::splat(longest) - radii) * (DVec3::splat(longest) + radii);
    let pull = radii * from;
    let (mut low, mut high) = (0.0, pull.length());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if (pull / (gap + middle)).length_squared() > 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (mut left, mut along, mut across) = (1.0, 0.0, 0.0);
    for i in 0..3 {
        if gap[i] == 0.0 {
            along += from[i] * from[i];
        } else {
            let part = pull[i] / (gap[i] + high);
            left -= part * part;
            across += (from[i] + radii[i] * part).powi(2);
        }
    }
    (longest * left.max(0.0).sqrt() + along.sqrt()).hypot(across.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn lying() -> DQuat {
        DQuat::from_rotation_z(0.7) * DQuat::from_rotation_y(FRAC_PI_2)
    }

    #[test]
    fn the_farthest_point_is_the_farthest_of_many() {
        let shapes = [
            Shape::Sphere { radius: 1.0 },
            Shape::Spherocylinder { diameter: 0.5, length: 4.0 },
            Shape::Ellipsoid { radii: [0.5, 1.0, 2.0] },
            Shape::Ellipsoid { radii: [1.0, 1.0, 1.01] },
            Shape::Ellipsoid { radii: [2.0, 2.0, 1.0] },
            Shape::Torus { major_radius: 1.0, minor_radius: 0.2 },
        ];
        for shape in shapes {
            let near = lying() * DVec3::new(0.004, 0.0, 0.003);
            for from in [DVec3::new(3.0, -1.0, 2.0), DVec3::new(0.0, 0.3, 0.1), near, lying() * DVec3::X, DVec3::ZERO] {
                let found = farthest(&shape, DVec3::new(1.0, 2.0, 3.0), lying(), from + DVec3::new(1.0, 2.0, 3.0));
                // The distance of the farthest point is the support function in some direction, and no direction gives
                // more.
                let steps = 200;
                let mut best = 0.0_f64;
                for i in 0..steps {
                    for j in 0..2 * steps {
                        let (a, b) = (PI * i as f64 / steps as f64, PI * j as f64 / steps as f64);
                        let n = DVec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos());
                        let to_x = DQuat::from_rotation_arc(n, DVec3::X);
                        best = best.max(shape.half_extents(to_x * lying()).x - n.dot(from));
                    }
                }
                assert!((found - best).abs() < 1e-3 && found > best - 1e-9, "{shape:?} {from}: {found} {best}");
            }
        }
    }
}
