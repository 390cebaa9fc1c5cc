//! An ellipsoid and a thickened point or segment: the largest `n . Delta - h(n) - half |n . u| - radius` over unit
//! normals.
//!
//! Either the normal is across the segment, and then it is that of a point and the ellipse that is the ellipsoid's
//! shadow along the segment; or the contact is at an end, and then it is that of a point and the ellipsoid. Each case
//! is one root (`point_ellipsoid`) without a start, and at most two are computed: the distance along the segment's line
//! is convex, so if its nearest point is beyond an end, that end is nearest.
//!
//! Degenerate cases: a segment so deep that the distance along it is no longer smooth (all candidates are compared; the
//! first among equals counts); a point or a line through the centre (see `point_ellipsoid`).

use super::Separation;
use super::peak::{Supporting, climb};
use super::point_ellipsoid;
use super::segments::Segment;
use super::support::Support;
use glam::DVec3;

/// Maxima this close, as a fraction of the sizes, are equal.
const TIE: f64 = 1e-13;

/// The separation of the ellipsoid about the origin and the segment about `delta`, thickened by `radius`.
pub(super) fn separation(delta: DVec3, body: Support, segment: Segment, radius: f64) -> Separation {
    let nearest = nearest(delta, body, segment);
    Separation {
        separation: nearest.value - radius,
        normal: nearest.normal,
        lever_a: nearest.point,
        lever_b: segment.axis * nearest.at - nearest.normal * radius,
    }
}

fn nearest(delta: DVec3, body: Support, segment: Segment) -> Candidate {
    if segment.half == 0.0 {
        return Candidate::at(delta, body, segment, point_normal(delta, body), 0.0);
    }
    let smooth = |c: Candidate| c.value > -body.least_curvature_radius();
    let across = Candidate::across(delta, body, segment, line_normal(delta, body, segment.axis));
    if smooth(across) && across.at.abs() <= segment.half {
        return across;
    }
    let nearer = segment.half.copysign(across.at);
    for end in [nearer, -nearer] {
        let normal = point_normal(delta + segment.axis * end, body);
        let at_end = Candidate::at(delta, body, segment, normal, end);
        if smooth(at_end) && at_end.is_nearest(segment) {
            return at_end;
        }
    }
    deepest(delta, body, segment, across)
}

/// A normal with the ellipsoid's point, the position on the segment, and the distance along the normal between them.
#[derive(Clone, Copy)]
struct Candidate {
    normal: DVec3,
    point: DVec3,
    at: f64,
    value: f64,
}

impl Candidate {
    /// A normal across the axis. The position is on the segment's line, and may be beyond an end.
    #[inline]
    fn across(delta: DVec3, body: Support, segment: Segment, normal: DVec3) -> Candidate {
        let (height, point) = body.value_and_point(normal);
        let at = (point - delta).dot(segment.axis);
        Candidate { normal, point, at, value: normal.dot(delta) - height }
    }

    /// A normal with a given position.
    #[inline]
    fn at(delta: DVec3, body: Support, segment: Segment, normal: DVec3, at: f64) -> Candidate {
        let (height, point) = body.value_and_point(normal);
        Candidate { normal, point, at, value: normal.dot(delta + segment.axis * at) - height }
    }

    /// Whether an end has the smallest coordinate along the normal of the whole segment, as required at a maximum.
    #[inline]
    fn is_nearest(self, segment: Segment) -> bool {
        self.at * self.normal.dot(segment.axis) <= 0.0
    }
}

/// The largest of all local maxima: across the line, at both ends, and at both ends from starts along the ellipsoid's
/// axes.
fn deepest(delta: DVec3, body: Support, segment: Segment, across: Candidate) -> Candidate {
    let tie = TIE * (delta.length() + body.radii.max_element() + segment.half);
    let mut best = Candidate { at: across.at.clamp(-segment.half, segment.half), ..across };
    for end in [-segment.half, segment.half] {
        let p = delta + segment.axis * end;
        let [x, y, z] = [body.axes.x_axis, body.axes.y_axis, body.axes.z_axis];
        let climbed = [x, -x, y, -y, z, -z].map(|start| climb(p, &[body], start).normal);
        for normal in [point_normal(p, body)].into_iter().chain(climbed) {
            let candidate = Candidate::at(delta, body, segment, normal, end);
            if candidate.is_nearest(segment) && candidate.value > best.value + tie {
                best = candidate;
            }
        }
    }
    best
}

/// The normal of the ellipsoid's surface point nearest to `p`.
#[inline]
pub(super) fn point_normal(p: DVec3, body: Support) -> DVec3 {
    body.axes * DVec3::from_array(point_ellipsoid::normal(body.radii.to_array(), body.to_body(p).to_array()))
}

/// The normal, across `axis`, of the ellipsoid's surface nearest to the line through `delta`: that of a point and an
/// ellipse. Its axes come from one plane rotation of the two columns of `diag(radii) R^T E`, which keeps the digits of
/// the smaller one (one-sided Jacobi).
fn line_normal(delta: DVec3, body: Support, axis: DVec3) -> DVec3 {
    let (e1, e2) = axis.any_orthonormal_pair();
    let (v1, v2) = (body.radii * body.to_body(e1), body.radii * body.to_body(e2));
    let twice = f64::atan2(2.0 * v1.dot(v2), v1.length_squared() - v2.length_squared());
    let (sine, cosine) = (0.5 * twice).sin_cos();
    let (e1, e2) = (e1 * cosine + e2 * sine, e2 * cosine - e1 * sine);
    let radii = [(v1 * cosine + v2 * sine).length(), (v2 * cosine - v1 * sine).length()];
    let [n1, n2] = point_ellipsoid::normal(radii, [delta.dot(e1), delta.dot(e2)]);
    e1 * n1 + e2 * n2
}
