//! Separations of bodies that cannot leave the plane: the maximum of `n . Delta - h_a(n) - h_b(-n)` over normals `n` in
//! the plane.
//!
//! If the bodies are apart, or overlap little, the normal of space is already in the plane by symmetry. If they overlap
//! deeply it may not be: the shortest separating motion of two rods with crossing axes is along z, for which a planar
//! scene has no unknown. Then the maximum is computed over the angle of `n`: samples bracket local maxima, and golden
//! section narrows them. The normals at right angles to a segment, where `h` has a kink, are additional samples.
//!
//! Degenerate cases: a normal at right angles to a segment, whose contact point is then the one nearest to that of the
//! other body; equal maxima, of which the first in order of angle counts.

use super::peak::Supporting;
use super::{Family, Placed, Separation, separation};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A normal that leans out of the plane by more than this is not in the plane; rounding gives less than 1e-12.
const OUT_OF_PLANE: f64 = 1e-3;
/// Samples of the circle: two ellipses of aspect 20:1 have their maxima over 0.05 rad apart.
const SAMPLES: usize = 128;
/// Golden section steps: each leaves 0.618 of the bracket, and 60 reduce 0.1 rad to rounding.
const STEPS: usize = 60;
/// A normal is at right angles to a segment if its cosine is below this; golden section locates a kink within rounding.
const RIGHT_ANGLE: f64 = 1e-9;

/// The separation of two bodies of a planar scene, as [`separation`], its normal in the x-y plane.
///
/// Rings have the separation of [`separation`]: if their circles cross in the plane, no normal in the plane is defined,
/// and the one along z is kept.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::internals::separation::planar_separation;
/// use relcp::separation::Placed;
/// use relcp::shape::Shape;
/// let shape = Shape::Spherocylinder { diameter: 0.5, length: 3.0 };
/// let along = |angle: f64| DQuat::from_rotation_z(angle) * DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
/// let a = Placed { shape, position: DVec3::ZERO, orientation: along(0.0) };
/// let crossing = Placed { shape, position: DVec3::new(0.0, 0.4, 0.0), orientation: along(1.5) };
/// let found = planar_separation(&a, &crossing, None).ok_or("unsupported pair")?;
/// assert!(found.normal.z == 0.0 && found.separation < -0.5);
/// # Ok::<(), &str>(())
/// ```
pub fn planar_separation(a: &Placed, b: &Placed, warm: Option<DVec3>) -> Option<Separation> {
    let found = separation(a, b, warm)?;
    let families = [Family::of(a), Family::of(b)];
    let ring = families.iter().any(|family| matches!(family, Family::Circle(..)));
    if found.normal.z.abs() <= OUT_OF_PLANE || ring {
        return Some(found);
    }
    Some(over_angles(b.position - a.position, &families))
}

fn over_angles(delta: DVec3, families: &[Family; 2]) -> Separation {
    let direction = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.0);
    let value = |angle: f64| {
        let n = direction(angle);
        n.dot(delta) - families[0].hull(n) - families[1].hull(-n)
    };
    let mut angles: Vec<f64> = (0..SAMPLES).map(|k| TAU * k as f64 / SAMPLES as f64).collect();
    for family in families {
        if let Family::Segment(segment, _) = family {
            let across = (segment.axis.y.atan2(segment.axis.x) + 0.5 * PI).rem_euclid(PI);
            angles.extend([across, across + PI]);
        }
    }
    angles.sort_by(f64::total_cmp);
    let values: Vec<f64> = angles.iter().map(|angle| value(*angle)).collect();
    let n = angles.len();
    let mut best = (f64::NEG_INFINITY, 0.0);
    for k in 0..n {
        let (before, after) = ((k + n - 1) % n, (k + 1) % n);
        if values[k] < values[before] || values[k] < values[after] {
            continue;
        }
        let low = angles[before] - if before > k { TAU } else { 0.0 };
        let high = angles[after] + if after < k { TAU } else { 0.0 };
        let angle = golden_section(value, low, high);
        for found in [(values[k], angles[k]), (value(angle), angle)] {
            if found.0 > best.0 {
                best = found;
            }
        }
    }
    let normal = direction(best.1);
    let (lever_a, lever_b) = contact_points(delta, families, normal);
    Separation { separation: best.0, normal, lever_a, lever_b }
}

/// The angle of a maximum between `low` and `high`.
fn golden_section(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut p, mut q) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_p, mut at_q) = (value(p), value(q));
    for _ in 0..STEPS {
        if at_p >= at_q {
            (high, q, at_q) = (q, p, at_p);
            p = high - ratio * (high - low);
            at_p = value(p);
        } else {
            (low, p, at_p) = (p, q, at_q);
            q = low + ratio * (high - low);
            at_q = value(q);
        }
    }
    0.5 * (low + high)
}

/// The support points of the two bodies at `normal` and `-normal`, each from its own centre.
fn contact_points(delta: DVec3, [a, b]: &[Family; 2], normal: DVec3) -> (DVec3, DVec3) {
    let (free_a, free_b) = (is_free(a, normal), is_free(b, normal));
    let (mut from, mut to) = (support_point(a, normal), support_point(b, -normal));
    // A segment at right angles to the normal touches along its length: take its point nearest to the other's.
    if let (true, Family::Segment(segment, radius)) = (free_a, a) {
        let along = (delta + to).dot(segment.axis).clamp(-segment.half, segment.half);
        from = along * segment.axis + *radius * normal;
    }
    if let (true, Family::Segment(segment, radius)) = (free_b, b) {
        let along = (from - delta).dot(segment.axis).clamp(-segment.half, segment.half);
        to = along * segment.axis - *radius * normal;
    }
    (from, to)
}

fn is_free(family: &Family, normal: DVec3) -> bool {
    matches!(family, Family::Segment(segment, _) if segment.axis.dot(normal).abs() < RIGHT_ANGLE)
}

fn support_point(family: &Family, normal: DVec3) -> DVec3 {
    match family {
        Family::Segment(segment, radius) => {
            let side = segment.axis.dot(normal);
            let end = if side.abs() < RIGHT_ANGLE { 0.0 } else { segment.half.copysign(side) };
            end * segment.axis + *radius * normal
        }
        Family::Circle(circle, radius) => (circle.radius + radius) * normal,
        Family::Ellipsoid(support) => support.value_and_point(normal).1,
        Family::Convex(posed) => posed.value_and_point(normal).1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;
    use glam::DQuat;

    fn rod(x: f64, y: f64, angle: f64) -> Placed {
        Placed {
            shape: Shape::Spherocylinder { diameter: 0.5, length: 3.0 },
            position: DVec3::new(x, y, 0.0),
            orientation: DQuat::from_rotation_z(angle) * DQuat::from_rotation_y(0.5 * PI),
        }
    }

    #[test]
    fn crossing_rods_are_pushed_apart_in_the_plane() {
        // A rod along x, crossed at a right angle 0.4 above its centre: the shortest separating motion, along y, is
        // 1.25 - 0.4 plus both radii.
        let (a, b) = (rod(0.0, 0.0, 0.0), rod(0.0, 0.4, 0.5 * PI));
        assert!(separation(&a, &b, None).is_some_and(|found| found.normal.z.abs() > 0.9));
        let found = planar_separation(&a, &b, None).expect("rods");
        assert!((found.separation + 1.25 - 0.4 + 0.5).abs() < 1e-9, "{found:?}");
        assert!(found.normal.abs_diff_eq(DVec3::Y, 1e-9));
    }

    #[test]
    fn points_agree_with_the_separation_and_moving_apart_by_it_ends_the_overlap() {
        let ellipse = |x: f64, angle: f64| Placed {
            shape: Shape::Ellipsoid { radii: [1.0, 2.0, 0.1] },
            position: DVec3::new(x, 0.1, 0.0),
            orientation: DQuat::from_rotation_z(angle),
        };
        let pairs = [
            (rod(0.0, 0.0, 0.3), rod(0.2, 0.1, 1.7)),
            (rod(0.0, 0.0, 0.3), rod(0.0, 0.0, 0.3)),
            (ellipse(0.0, 0.2), ellipse(0.4, 1.1)),
            (rod(0.0, 0.0, 0.3), ellipse(0.1, 0.4)),
        ];
        for (a, b) in pairs {
            let found = planar_separation(&a, &b, None).expect("convex");
            assert!(found.normal.z.abs() < 1e-12 && found.separation < 0.0, "{found:?}");
            let points = b.position - a.position + found.lever_b - found.lever_a;
            assert!((found.normal.dot(points) - found.separation).abs() < 1e-9, "{found:?}");
            let moved = Placed { position: b.position - found.separation * found.normal, ..b };
            let after = planar_separation(&a, &moved, None).expect("convex");
            assert!(after.separation.abs() < 1e-9, "{after:?}");
        }
    }
}
