//! The interior of a body: its farthest point in a direction, and points that represent equal parts of it.
//!
//! The points of rods, spheres and ellipsoids are those of a Halton sequence in the body's box that are inside the body
//! (J. H. Halton, Numer. Math. 2, 84 (1960)); those of a ring are on its centreline.

use crate::separation::point_to_convex;
use crate::shape::{Centreline, Geometry, Shape};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// The number of sample points per body. In a colony of 512 cells the filled part of rings with the width of one
/// diameter has an error below 0.004 from the fifth ring on and below 0.01 in the first four (0.003 and 0.003 with
/// 1,024, 0.016 and 0.032 with 64), compared with points on a grid of 1/50 of a diameter.
const TRIED: usize = 512;

/// The points in the box from -1 to 1.
static IN_BOX: LazyLock<Vec<DVec3>> =
    LazyLock::new(|| (1..=TRIED).map(|k| DVec3::new(halton(k, 2), halton(k, 3), halton(k, 5))).collect());

/// Fills `out` with points, relative to the body's centre, that represent equal parts of it.
pub(super) fn points(shape: &Shape, orientation: DQuat, axis: Option<DVec3>, planar: bool, out: &mut Vec<DVec3>) {
    out.clear();
    match shape.geometry() {
        Geometry::Centreline { curve: Centreline::Circle { radius }, .. } => ring(radius, orientation, planar, out),
        _ if planar => in_plane(shape, orientation, axis, out),
        _ => in_space(shape, orientation, out),
    }
}

fn ring(radius: f64, orientation: DQuat, planar: bool, out: &mut Vec<DVec3>) {
    let axis = orientation * DVec3::Z;
    if planar && axis.z.abs() < 0.5 {
        // It is perpendicular to the plane and intersects it in two discs.
        let side = DVec3::Z.cross(axis).normalize() * radius;
        out.extend([-side, side]);
        return;
    }
    let angle = |k: usize| TAU * k as f64 / TRIED as f64;
    out.extend((0..TRIED).map(|k| orientation * (radius * DVec3::new(angle(k).cos(), angle(k).sin(), 0.0))));
}

fn in_space(shape: &Shape, orientation: DQuat, out: &mut Vec<DVec3>) {
    let half = shape.half_extents(DQuat::IDENTITY);
    let tried = IN_BOX.iter().map(|point| half * *point);
    out.extend(tried.filter(|point| holds(shape, *point)).map(|point| orientation * point));
}

fn in_plane(shape: &Shape, orientation: DQuat, axis: Option<DVec3>, out: &mut Vec<DVec3>) {
    // The box is aligned with the axis, so that a long body fills it.
    let turn = DQuat::from_rotation_z(axis.map_or(0.0, |axis| axis.y.atan2(axis.x)));
    let half = shape.half_extents(turn.inverse() * orientation);
    let tried = IN_BOX.iter().map(|point| turn * (half * *point).with_z(0.0));
    let to_body = orientation.inverse();
    out.extend(tried.filter(|point| holds(shape, to_body * *point)));
}

/// Whether a point in body axes is inside a convex shape.
fn holds(shape: &Shape, point: DVec3) -> bool {
    match shape.geometry() {
        Geometry::Ellipsoid { radii } => (point / radii).length_squared() <= 1.0,
        Geometry::Convex(shape) => point_to_convex(shape, point).0 <= 0.0,
        Geometry::Centreline { curve, radius } => {
            let half = match curve {
                Centreline::Segment { half } => half,
                Centreline::Point | Centreline::Circle { .. } => 0.0,
            };
            let nearest = DVec3::Z * point.z.clamp(-half, half);
            point.distance_squared(nearest) <= radius * radius
        }
    }
}

/// The radical inverse of `k` in a base, from -1 to 1.
fn halton(mut k: usize, base: usize) -> f64 {
    let (mut value, mut part) = (0.0, 1.0);
    while k > 0 {
        part /= base as f64;
        value += part * (k % base) as f64;
        k /= base;
    }
    2.0 * value - 1.0
}

/// The body's farthest point along a unit vector, from its centre.
pub(super) fn support(shape: &Shape, orientation: DQuat, normal: DVec3) -> DVec3 {
    let axis = orientation * DVec3::Z;
    match shape.geometry() {
        Geometry::Centreline { curve, radius } => {
            let on_curve = match curve {
                Centreline::Point => DVec3::ZERO,
                Centreline::Segment { half } => axis * half.copysign(axis.dot(normal)),
                Centreline::Circle { radius } => radius * normal.reject_from_normalized(axis).normalize_or_zero(),
            };
            on_curve + radius * normal
        }
        Geometry::Ellipsoid { radii } => {
            let scaled = radii * (orientation.inverse() * normal);
            orientation * (radii * scaled.normalize())
        }
        Geometry::Convex(shape) => orientation * shape.point(orientation.inverse() * normal),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separation::farthest;
    use crate::shape::Convex;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn lying() -> DQuat {
        DQuat::from_rotation_z(0.7) * DQuat::from_rotation_y(FRAC_PI_2)
    }

    #[test]
    fn sections_are_those_of_the_plane() {
        let rod = Shape::Spherocylinder { diameter: 1.0, length: 3.0 };
        assert!((rod.section(lying()) - (2.0 + 0.25 * PI)).abs() < 1e-15);
        assert!((rod.section(DQuat::IDENTITY) - 0.25 * PI).abs() < 1e-15);
        let egg = Shape::Ellipsoid { radii: [1.0, 2.0, 3.0] };
        assert!((egg.section(DQuat::IDENTITY) - 2.0 * PI).abs() < 1e-15);
        assert!((egg.section(lying()) - 6.0 * PI).abs() < 1e-14);
        let ring = Shape::Torus { major_radius: 2.0, minor_radius: 0.5 };
        assert!((ring.section(DQuat::IDENTITY) - PI * (2.5_f64.powi(2) - 1.5_f64.powi(2))).abs() < 1e-14);
        assert!((ring.section(lying()) - 2.0 * PI * 0.25).abs() < 1e-15);
    }

    #[test]
    fn a_custom_ellipsoid_has_the_ellipsoids_section_and_farthest_point() {
        let radii = DVec3::new(1.0, 2.0, 3.0);
        let custom = Convex::new(move |n: DVec3| radii * radii * n / (radii * n).length()).unwrap();
        let (custom, own) = (Shape::Convex(custom), Shape::Ellipsoid { radii: radii.to_array() });
        for turn in [DQuat::IDENTITY, lying()] {
            assert!((custom.section(turn) / own.section(turn) - 1.0).abs() < 1e-14);
        }
        let flat = DVec3::new(1.0, 50.0, 50.0);
        let flat = Shape::Convex(Convex::new(move |n: DVec3| flat * flat * n / (flat * n).length()).unwrap());
        let off = flat.section(DQuat::IDENTITY) / (50.0 * PI) - 1.0;
        assert!(off.abs() < 1e-6, "{off:e}");
        for from in [DVec3::new(3.0, -1.0, 2.0), DVec3::new(0.0, 0.3, 0.1), DVec3::ZERO, DVec3::X * 9.0] {
            let far = |shape: &Shape| farthest(shape, DVec3::new(1.0, 2.0, 3.0), lying(), from);
            assert!((far(&custom) - far(&own)).abs() < 1e-12, "{from}: {} {}", far(&custom), far(&own));
        }
        let normal = DVec3::new(0.6, 0.0, -0.8);
        assert!(support(&custom, lying(), normal).abs_diff_eq(support(&own, lying(), normal), 1e-13));
    }

    #[test]
    fn points_lie_inside_about_the_centre() {
        let egg = DVec3::new(0.5, 0.5, 1.5);
        let mut found = Vec::new();
        let shapes = [
            Shape::Sphere { radius: 1.0 },
            Shape::Spherocylinder { diameter: 0.5, length: 4.0 },
            Shape::Ellipsoid { radii: [0.5, 1.0, 2.0] },
            Shape::Torus { major_radius: 1.0, minor_radius: 0.01 },
            Shape::Convex(Convex::new(move |n: DVec3| n + egg * egg * n / (egg * n).length()).unwrap()),
        ];
        for shape in shapes {
            for planar in [false, true] {
                let axis = crate::measure::axis(&shape, lying(), planar);
                points(&shape, lying(), axis, planar, &mut found);
                let least = if matches!(shape, Shape::Torus { .. }) { 2 } else { 25 };
                assert!(found.len() >= least, "{shape:?} {}", found.len());
                let size = shape.bounding_radius();
                assert!(found.iter().all(|point| point.length() <= size && !(planar && point.z.abs() > 1e-12)));
                let mean = found.iter().sum::<DVec3>() / found.len() as f64;
                assert!(mean.length() < 0.1 * size, "{shape:?} {mean}");
            }
        }
    }

    #[test]
    fn supports_agree_with_boxes() {
        let shapes = [
            Shape::Sphere { radius: 1.0 },
            Shape::Spherocylinder { diameter: 0.5, length: 4.0 },
            Shape::Ellipsoid { radii: [0.5, 1.0, 2.0] },
            Shape::Torus { major_radius: 1.0, minor_radius: 0.2 },
        ];
        for shape in shapes {
            for (k, normal) in DVec3::AXES.into_iter().enumerate() {
                let found = support(&shape, lying(), normal).dot(normal);
                assert!((found - shape.half_extents(lying())[k]).abs() < 1e-12, "{shape:?} {normal}");
            }
        }
    }
}
