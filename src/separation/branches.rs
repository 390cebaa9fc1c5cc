//! The smooth branches of a pair's separation: a separation is the minimum of several smooth functions of the two
//! poses, and a pair can touch in several places at once.
//!
//! * Two segments: each end against the other segment, and in space the common perpendicular if it is inside both. An
//!   end against an end counts once, as an end of the first body.
//! * Two rings: each minimum of the distance along the smaller one, numbered by its angle there; along the second if
//!   both have the same size. Linked rings under tension touch in two places.
//! * A ring and a rod: the minima of the distance along the rod, at most two, before and after the point nearest to the
//!   ring's axis. A rod across a ring touches it twice.
//! * A ring and an ellipsoid or custom shape: each minimum of the distance along the ring, numbered by its angle there;
//!   of more than four, the nearest. A ring around an egg touches it at both tips.
//! * All other pairs have one branch, the separation itself.
//!
//! The distance at a fixed point of one body is never less than the separation, so no branch forbids a motion that the
//! surfaces allow.
//!
//! Degenerate cases: axes that cross or nearly cross, where the distance of an end no longer determines its side, have
//! only the separation itself; so do segments of zero length.

#[cfg(feature = "gpu")]
pub(crate) mod gpu;

use super::circles::{self, Circle};
use super::convex::Body;
use super::peak::Supporting;
use super::segments::{self, Segment};
use super::{Family, Nearest, Placed, Separation};
use super::{circle_convex, circle_segment};
use glam::DVec3;

/// Set in the number of a branch at an end, and in no other contact's number.
const BRANCH: u32 = 1 << 31;

/// The number of the separation itself as a branch: the only branch of most pairs, the common perpendicular of two
/// rods, and of two rings if the distance has no minimum.
pub const WHOLE: u32 = 0;

/// The largest number of branches of a pair, including the separation itself.
pub(crate) const BRANCHES: u32 = 5;

/// The number of the branch at an index of the list of all: the separation itself, the ends of the first segment, those
/// of the second; or the minima of two rings, or of a ring and a rod.
#[cfg(feature = "gpu")]
pub(crate) fn branch_in_place(place: u32) -> u32 {
    if place == 0 { WHOLE } else { BRANCH | (place - 1) }
}

/// The index of a branch in that list, if `feature` is a branch.
pub(crate) fn place_of_branch(feature: u32) -> Option<u32> {
    let place = if feature == WHOLE { 0 } else { (feature ^ BRANCH).saturating_add(1) };
    (place < BRANCHES).then_some(place)
}

/// Branches count down to this depth, over the sum of the radii of two centrelines: deeper, the axes soon cross.
pub(crate) const DEEPEST: f64 = 0.5;

/// The smallest slack, in sums of the radii: for a pair that did not turn before. A colony to 512 cells takes 27
/// products and 0.007 recursions a step from 0.001 to 0.006, and 76 and 0.48 with none.
pub(crate) const LEAST_SLACK: f64 = 0.001;

/// The slack in space, in sums of the radii: that of rods as parallel as solves leave them, ends a tenth of the overlap
/// tolerance apart. There the nearest points of rods lie inside both and slide, so that another branch rarely becomes
/// the nearest: 1,000 rods packed to t = 15 take 403 products a step at dt 0.02 and 1,274 at 0.1, and 430 and 1,468
/// with the slack of the plane.
pub(crate) const SLACK_IN_SPACE: f64 = 2e-5;

/// Minima of two rings count up to this many sums of the radii of their tubes above the nearest.
pub(crate) const WINDOW: f64 = 1.0;

/// The same for two rings, with the minima searched along either of them: over a million poses the two differ by 2e-11.
pub(crate) const RING_ROUNDING: f64 = 1e-10;

/// Two ways to compute a distance differ by less than this part of the sizes.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Whether a contact's number is that of a branch of smooth surfaces.
#[cfg(any(feature = "files", test))]
pub fn is_branch(feature: u32) -> bool {
    feature == WHOLE || feature & BRANCH != 0
}

/// Calls `found` with the number and the separation of every branch of a pair that is at most `slack` above `nearest`,
/// the pair's separation; at least once.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::internals::separation::branches;
/// use relcp::separation::{Placed, separation};
/// use relcp::shape::Shape;
/// // Two rods side by side touch at both ends of the interval that they share.
/// let shape = Shape::Spherocylinder { diameter: 0.5, length: 2.5 };
/// let rod = |x: f64, z: f64| Placed { shape, position: DVec3::new(x, 0.0, z), orientation: DQuat::IDENTITY };
/// let (a, b) = (rod(0.0, 0.0), rod(0.6, 0.5));
/// let nearest = separation(&a, &b, None).ok_or("unsupported pair")?;
/// let mut places = Vec::new();
/// branches(&a, &b, &nearest, 1e-9, |_, found| places.push(found.lever_a.z));
/// assert_eq!(places, [1.0, -0.5]);
/// # Ok::<(), &str>(())
/// ```
pub fn branches(a: &Placed, b: &Placed, nearest: &Separation, slack: f64, mut found: impl FnMut(u32, Separation)) {
    match (Family::of(a), Family::of(b)) {
        (Family::Segment(of_a, ra), Family::Segment(of_b, rb)) => {
            let delta = b.position - a.position;
            if of_a.half > 0.0 && of_b.half > 0.0 && nearest.separation > -DEEPEST * (ra + rb) {
                of_segments(delta, (of_a, ra), (of_b, rb), nearest, slack, &mut found);
            } else {
                found(WHOLE, *nearest);
            }
        }
        (Family::Circle(of_a, ra), Family::Circle(of_b, rb)) if nearest.separation > -DEEPEST * (ra + rb) => {
            let delta = b.position - a.position;
            of_circles(delta, (of_a, ra), (of_b, rb), nearest, slack, &mut found);
        }
        (Family::Circle(ring, ra), Family::Segment(rod, rb)) if rod.half > 0.0 => {
            let delta = b.position - a.position;
            let turn = |found: Nearest| found.thickened(ra, rb);
            of_circle_segment(delta, (ring, rod), (nearest, ra + rb), slack, turn, &mut found);
        }
        (Family::Segment(rod, ra), Family::Circle(ring, rb)) if rod.half > 0.0 => {
            let delta = a.position - b.position;
            let turn = |found: Nearest| found.thickened(rb, ra).flipped();
            of_circle_segment(delta, (ring, rod), (nearest, ra + rb), slack, turn, &mut found);
        }
        (Family::Circle(ring, radius), Family::Ellipsoid(_) | Family::Convex(_)) => {
            let delta = b.position - a.position;
            of_ring_and_body(delta, (ring, radius), Family::of(b), (nearest, slack), |at| at, &mut found);
        }
        (Family::Ellipsoid(_) | Family::Convex(_), Family::Circle(ring, radius)) => {
            let delta = a.position - b.position;
            of_ring_and_body(delta, (ring, radius), Family::of(a), (nearest, slack), Separation::flipped, &mut found);
        }
        _ => found(WHOLE, *nearest),
    }
}

/// How far a branch of a pair may lie above its separation `nearest` and still become active in a step with the
/// relative rotation vector `turned` and the slide `slid`, a length; in space only the rounding.
///
/// In the plane a turn about `e` changes the gap at a distance `d` along the axis `u` from the contact by `d |e . (u x
/// n)|`, and a slide of `s` across crossed axes a distance `D` apart by `s^2 / 2 D`.
pub fn branch_slack(a: &Placed, b: &Placed, nearest: &Separation, (turned, slid): (DVec3, f64), planar: bool) -> f64 {
    match (Family::of(a), Family::of(b)) {
        (Family::Segment(_, ra), Family::Segment(_, rb)) if !planar => SLACK_IN_SPACE * (ra + rb),
        (Family::Segment(a, ra), Family::Segment(b, rb)) => {
            let tilt = |axis: DVec3| turned.dot(axis.cross(nearest.normal)).abs();
            let tilted = tilt(a.axis).max(tilt(b.axis)) * 2.0 * a.half.min(b.half);
            tilted + 0.5 * slid * slid / (ra + rb) + LEAST_SLACK * (ra + rb)
        }
        (Family::Circle(a, ra), Family::Circle(b, rb)) => {
            turned.length() * 2.0 * a.radius.min(b.radius) + slid + LEAST_SLACK * (ra + rb)
        }
        (Family::Circle(ring, ra), Family::Segment(rod, rb)) | (Family::Segment(rod, ra), Family::Circle(ring, rb)) => {
            turned.length() * 2.0 * rod.half.min(ring.radius) + slid + LEAST_SLACK * (ra + rb)
        }
        (Family::Circle(ring, radius), other) | (other, Family::Circle(ring, radius)) => match other.convex() {
            Some(body) => {
                let least = LEAST_SLACK * (radius + half_thickness(body));
                turned.length() * 2.0 * ring.radius.min(body.size()) + slid + least
            }
            None => 0.0,
        },
        _ => 0.0,
    }
}

/// The separation of the branch with this number; the pair's separation if the pair has no such branch.
pub fn branch(a: &Placed, b: &Placed, nearest: &Separation, feature: u32) -> Separation {
    let mut wanted = *nearest;
    branches(a, b, nearest, f64::INFINITY, |number, found| {
        if number == feature {
            wanted = found;
        }
    });
    wanted
}

/// The separation at a branch of two segments by its number, at any height above the pair's; `None` for a branch that
/// is the separation itself.
pub(crate) fn separation_at(a: &Placed, b: &Placed, feature: u32) -> Option<f64> {
    let (Family::Segment(of_a, ra), Family::Segment(of_b, rb)) = (Family::of(a), Family::of(b)) else { return None };
    let number = place_of_branch(feature)?.checked_sub(1)?;
    let delta = b.position - a.position;
    let end_of = |segment: Segment| if number % 2 == 0 { -segment.half } else { segment.half } * segment.axis;
    let (end, other) = if number < 2 { (end_of(of_a) - delta, of_b) } else { (end_of(of_b) + delta, of_a) };
    let gap = end - end.dot(other.axis).clamp(-other.half, other.half) * other.axis;
    Some(gap.length() - (ra + rb))
}

fn of_circles(
    delta: DVec3,
    (a, ra): (Circle, f64),
    (b, rb): (Circle, f64),
    nearest: &Separation,
    slack: f64,
    found: &mut impl FnMut(u32, Separation),
) {
    let radii = ra + rb;
    let rounding = RING_ROUNDING * (radii + delta.length() + a.radius + b.radius);
    let most = nearest.separation + slack + rounding;
    // Counted in a fixed window, so that a minimum has the same number for every slack.
    let window = nearest.separation + radii + WINDOW * radii;
    let (mut number, mut any) = (0, false);
    let mut keep = |separation: Separation| {
        if separation.separation <= most {
            found(BRANCH | number, separation);
            any = true;
        }
        number += 1;
    };
    if a.radius < b.radius {
        circles::minima(-delta, b, a, window, |found| keep(found.thickened(rb, ra).flipped()));
    } else {
        circles::minima(delta, a, b, window, |found| keep(found.thickened(ra, rb)));
    }
    if !any {
        found(WHOLE, *nearest);
    }
}

/// `delta` is from the ring to the rod; `turn` converts the result to a separation of the pair.
fn of_circle_segment(
    delta: DVec3,
    (ring, rod): (Circle, Segment),
    (nearest, radii): (&Separation, f64),
    slack: f64,
    turn: impl Fn(Nearest) -> Separation,
    found: &mut impl FnMut(u32, Separation),
) {
    let rounding = ROUNDING * (radii + delta.length() + ring.radius + rod.half);
    let most = nearest.separation + slack + rounding;
    let mut any = false;
    if nearest.separation > -DEEPEST * radii {
        circle_segment::minima(delta, ring, rod, |number, at| {
            let separation = turn(at);
            if separation.separation <= most {
                found(BRANCH | number, separation);
                any = true;
            }
        });
    }
    if !any {
        found(WHOLE, *nearest);
    }
}

/// Half the smallest extent of a body.
fn half_thickness(body: Body) -> f64 {
    body.size() / body.aspect()
}

/// `delta` is from the ring to the body; `turn` converts the result to a separation of the pair.
fn of_ring_and_body(
    delta: DVec3,
    (ring, radius): (Circle, f64),
    family: Family,
    (nearest, slack): (&Separation, f64),
    turn: impl Fn(Separation) -> Separation,
    found: &mut impl FnMut(u32, Separation),
) {
    let (mut number, mut any) = (0, false);
    if let Some(body) = family.convex()
        && nearest.separation > -(radius + DEEPEST * body.roundness())
    {
        let rounding = RING_ROUNDING * (radius + delta.length() + ring.radius + body.size());
        let most = nearest.separation + slack + rounding;
        let window = nearest.separation + WINDOW * (radius + half_thickness(body));
        circle_convex::minima(delta, (ring, radius), body, window, |separation| {
            if separation.separation <= most {
                found(BRANCH | number, turn(separation));
                any = true;
            }
            number += 1;
        });
    }
    if !any {
        found(WHOLE, *nearest);
    }
}

fn of_segments(
    delta: DVec3,
    (a, ra): (Segment, f64),
    (b, rb): (Segment, f64),
    nearest: &Separation,
    slack: f64,
    found: &mut impl FnMut(u32, Separation),
) {
    let most = nearest.separation + slack + ROUNDING * (ra + rb + a.half + b.half);
    let mut any = segments::cross_inside(delta, a, b);
    if any {
        found(WHOLE, *nearest);
    }
    let mut keep = |number: u32, from: DVec3, to: DVec3| {
        let gap = delta + to - from;
        let distance = gap.length();
        if distance - (ra + rb) <= most {
            let normal = gap / distance;
            found(BRANCH | number, Nearest { from, to, normal, distance }.thickened(ra, rb));
            any = true;
        }
    };
    // The ends of b that were counted with an end of a.
    let mut counted = [false; 2];
    for (k, end) in [(0, -a.half), (1, a.half)] {
        let from = end * a.axis;
        let along = (from - delta).dot(b.axis).clamp(-b.half, b.half);
        let to = along * b.axis;
        let back = (delta + to).dot(a.axis).clamp(-a.half, a.half);
        for (other, at) in [-b.half, b.half].into_iter().enumerate() {
            counted[other] |= along == at && back == end;
        }
        keep(k, from, to);
    }
    for (k, end) in [(0, -b.half), (1, b.half)] {
        if !counted[k as usize] {
            let to = end * b.axis;
            let along = (delta + to).dot(a.axis).clamp(-a.half, a.half);
            keep(2 + k, along * a.axis, to);
        }
    }
    if !any {
        found(WHOLE, *nearest);
    }
}

#[cfg(test)]
mod tests;
