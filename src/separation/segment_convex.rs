//! A custom shape and a thickened point or segment: the largest `n . Delta - h(n) - half |n . u| - radius` over unit
//! normals.
//!
//! Either the normal is across the segment, and the position on it is that of the body's point; or the contact is at an
//! end, and is that of a point and the body. The distance of a point from the body, negative inside, is a maximum of
//! linear functions, so it is convex along the segment's line: if its minimum is beyond an end, that end is nearest.
//! The minimum is the separation as long as the body, shrunk by a ball that rolls inside it, does not reach the
//! centreline (see `peak`): the centreline may be inside by the least radius of curvature. At larger depth, all local
//! maxima from fixed starts are compared, across the segment and at both ends.
//!
//! Degenerate cases: a point at the centre, or a line through it (fixed starts); equal maxima (the
//! first in the order of starts).

use super::Separation;
use super::convex::{Posed, TIE, highest};
use super::direction::{across, perpendicular};
use super::farthest::highest_across;
use super::flat::point_across;
use super::peak::{Peak, Supporting, climb, climb_across};
use super::segments::Segment;
use glam::DVec3;

/// The separation of the custom shape about the origin and the segment about `delta`, thickened by `radius`.
pub(super) fn separation(delta: DVec3, body: Posed, segment: Segment, radius: f64) -> Separation {
    let (peak, at) = nearest(delta, body, segment);
    Separation {
        separation: peak.value - radius,
        normal: peak.normal,
        lever_a: point_across(delta + segment.axis * at, body, &peak),
        lever_b: segment.axis * at - peak.normal * radius,
    }
}

/// The maximum for a point: its value is the distance, negative inside.
pub(super) fn of_point(p: DVec3, body: Posed) -> Peak<1> {
    let peak = climb(p, &[body], p.try_normalize().unwrap_or(DVec3::X));
    if peak.value > -body.roundness() {
        return peak;
    }
    let starts = p.try_normalize().into_iter().chain(body.starts());
    highest(p, &[body], starts).unwrap_or(peak)
}

/// The maximum and the position on the segment.
fn nearest(delta: DVec3, body: Posed, segment: Segment) -> (Peak<1>, f64) {
    if segment.half == 0.0 {
        return (of_point(delta, body), 0.0);
    }
    let smooth = |peak: &Peak<1>| peak.value > -body.roundness();
    let beside = across(delta, segment.axis).and_then(DVec3::try_normalize);
    let start = beside.unwrap_or(perpendicular(segment.axis));
    let across = climb_across(delta, body, segment.axis, start);
    let place = (across.points[0] - delta).dot(segment.axis);
    if smooth(&across) && place.abs() <= segment.half {
        return (across, place);
    }
    let nearer = segment.half.copysign(place);
    for end in [nearer, -nearer] {
        let p = delta + segment.axis * end;
        let at_end = climb(p, &[body], p.try_normalize().unwrap_or(start));
        if smooth(&at_end) && is_nearest(&at_end, end, segment) {
            return (at_end, end);
        }
    }
    deepest(delta, body, segment)
}

/// Whether an end has the smallest coordinate along the normal of the whole segment, as required at a maximum.
fn is_nearest(peak: &Peak<1>, end: f64, segment: Segment) -> bool {
    end * peak.normal.dot(segment.axis) <= 0.0
}

/// The highest of all peaks from fixed starts.
fn deepest(delta: DVec3, body: Posed, segment: Segment) -> (Peak<1>, f64) {
    let tie = TIE * (delta.length() + body.size() + segment.half);
    let across = highest_across(delta, body, segment.axis);
    let place = (across.points[0] - delta).dot(segment.axis).clamp(-segment.half, segment.half);
    let mut best = (across, place);
    for end in [-segment.half, segment.half] {
        let p = delta + segment.axis * end;
        for start in p.try_normalize().into_iter().chain(body.starts()) {
            let peak = climb(p, &[body], start);
            if is_nearest(&peak, end, segment) && peak.value > best.0.value + tie {
                best = (peak, end);
            }
        }
    }
    best
}
