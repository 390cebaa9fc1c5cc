//! The axis of a body, for measures of order: a line without a direction.
//!
//! For a rod it is the centreline, for a ring or a spheroid the axis of symmetry, for other ellipsoids the longest
//! axis. In the plane it is the longer direction of the outline. A sphere, a custom shape, and a body with a circular
//! outline in the plane have none.

use crate::shape::{Centreline, Geometry, PLANAR_TOLERANCE, Shape};
use glam::{DQuat, DVec3};

/// Sizes that differ by less than this fraction are equal: rounding must not give a ball an axis.
const SAME: f64 = 1e-9;

/// The axis of a body as a unit vector with an arbitrary sign; `None` if it has none.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::measure::axis;
/// use relcp::shape::Shape;
/// let rod = Shape::Spherocylinder { diameter: 1.0, length: 3.0 };
/// assert_eq!(axis(&rod, DQuat::IDENTITY, false), Some(DVec3::Z));
/// assert_eq!(axis(&rod, DQuat::IDENTITY, true), None); // it stands on the plane
/// assert_eq!(axis(&Shape::Sphere { radius: 1.0 }, DQuat::IDENTITY, false), None);
/// ```
pub fn axis(shape: &Shape, orientation: DQuat, planar: bool) -> Option<DVec3> {
    let axis = match shape.geometry() {
        Geometry::Centreline { curve: Centreline::Point, .. } | Geometry::Convex(_) => return None,
        Geometry::Centreline { curve: Centreline::Segment { half }, radius } if same(radius, half + radius) => {
            return None;
        }
        Geometry::Centreline { curve: Centreline::Segment { .. } | Centreline::Circle { .. }, .. } => DVec3::Z,
        Geometry::Ellipsoid { radii } if planar => return in_plane(radii.to_array(), orientation),
        Geometry::Ellipsoid { radii } => of_ellipsoid(radii.to_array())?,
    };
    let axis = (orientation * axis).normalize();
    if !planar {
        return Some(axis);
    }
    let flat = DVec3::new(axis.x, axis.y, 0.0);
    (flat.length() > PLANAR_TOLERANCE).then(|| flat.normalize())
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.max(b)
}

fn of_ellipsoid([a, b, c]: [f64; 3]) -> Option<DVec3> {
    match (same(a, b), same(b, c), same(c, a)) {
        (true, true, _) => None,
        (true, ..) => Some(DVec3::Z),
        (_, true, _) => Some(DVec3::X),
        (.., true) => Some(DVec3::Y),
        _ if a > b && a > c => Some(DVec3::X),
        _ if b > c => Some(DVec3::Y),
        _ => Some(DVec3::Z),
    }
}

/// The longer of an ellipsoid's two axes in the plane.
fn in_plane(radii: [f64; 3], orientation: DQuat) -> Option<DVec3> {
    let axes = DVec3::AXES.map(|axis| orientation * axis);
    let across = (0..3).max_by(|i, j| axes[*i].z.abs().total_cmp(&axes[*j].z.abs())).unwrap_or(2);
    let [i, j] = [(across + 1) % 3, (across + 2) % 3];
    if same(radii[i], radii[j]) {
        return None;
    }
    let longer = axes[if radii[i] > radii[j] { i } else { j }];
    Some(DVec3::new(longer.x, longer.y, 0.0).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn each_shape_has_the_axis_of_its_symmetry() {
        let of = |radii, planar| axis(&Shape::Ellipsoid { radii }, DQuat::IDENTITY, planar);
        assert_eq!(of([1.0, 1.0, 2.0], false), Some(DVec3::Z));
        assert_eq!(of([1.0, 1.0, 0.5], false), Some(DVec3::Z));
        assert_eq!(of([0.5, 1.0, 1.0], false), Some(DVec3::X));
        assert_eq!(of([1.0, 0.5, 1.0], false), Some(DVec3::Y));
        assert_eq!(of([1.0, 3.0, 2.0], false), Some(DVec3::Y));
        assert_eq!(of([1.0, 1.0, 1.0 + 1e-12], false), None);
        assert_eq!(of([1.0, 1.0, 2.0], true), None);
        assert_eq!(of([1.0, 2.0, 3.0], true), Some(DVec3::Y));
        let ring = Shape::Torus { major_radius: 1.0, minor_radius: 0.1 };
        assert_eq!(axis(&ring, DQuat::IDENTITY, true), None);
        let upright = axis(&ring, DQuat::from_rotation_y(FRAC_PI_2), true).unwrap();
        assert!((upright.x.abs() - 1.0).abs() < 1e-15 && upright.z == 0.0);
        let ball = Shape::Spherocylinder { diameter: 1.0, length: 1.0 };
        assert_eq!(axis(&ball, DQuat::IDENTITY, false), None);
    }
}
