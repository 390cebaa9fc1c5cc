//! A circle and a point or segment: the nearest points of both.
//!
//! The point of the circle nearest to a given point has a closed form; the unknown is the position `t` along the
//! segment. With `z` the height over the circle's plane and `rho = sqrt(m^2 + k^2 (t - t_a)^2)` the distance from its
//! axis, the squared distance `z^2 + (rho - R)^2` has second derivative `2 - 2 R k^2 m^2 / rho^3` in `t`: it is convex
//! outside the interval about `t_a` where `rho^3 < R k^2 m^2`, and concave inside, where there is no minimum. So there
//! are at most two minima, each alone in a convex piece, and the search is exact.
//!
//! Degenerate cases: a point on the axis up to rounding (a fixed direction in the plane, see `Circle::toward`); a
//! segment along the axis up to rounding, which has no single point nearest to it (the point nearest to the centre); a
//! line that passes through the axis (`near_axis`); a segment that meets the circle (`meeting`); two equal minima (the
//! first along the segment).

use super::Nearest;
use super::circles::Circle;
use super::direction::across;
use super::meeting::{self, CurvePoint};
use super::segments::Segment;
use glam::DVec3;

/// Distances this close, as a fraction of the sizes, are equal.
const TIE: f64 = 1e-13;
/// The largest number of steps of the refinement; each at least halves the bracket, and no bracket is wider than 2^53
/// roundings.
const MAX_STEPS: usize = 60;

/// Nearest points of the circle `a` about the origin and the segment `b` about `delta`.
pub(super) fn nearest(delta: DVec3, a: Circle, b: Segment) -> Nearest {
    let tie = TIE * (delta.length() + a.radius + b.half);
    let at = if b.half > 0.0 { place(delta, &a, b, tie) } else { 0.0 };
    at_place(delta, a, b, at)
}

/// The nearest points at each minimum of the distance along the segment, which has a length: the one before the point
/// nearest to the axis and the one after it, by number.
pub(super) fn minima(delta: DVec3, a: Circle, b: Segment, mut found: impl FnMut(u32, Nearest)) {
    let tie = TIE * (delta.length() + a.radius + b.half);
    for (number, side) in sides(delta, &a, b).into_iter().enumerate() {
        let at = minimum(delta, &a, b, &side);
        // If the distance keeps falling beyond the piece, its border is not a minimum; otherwise both pieces have it.
        if side.low < side.high && ((at - side.inner).abs() > tie || at.abs() == b.half) {
            found(number as u32, at_place(delta, a, b, at));
        }
    }
}

/// The point of the circle nearest to a position on the segment.
fn at_place(delta: DVec3, a: Circle, b: Segment, at: f64) -> Nearest {
    let size = delta.length() + a.radius + b.half;
    let to = b.axis * at;
    let toward = a.toward(delta + to);
    let from = toward * a.radius;
    let gap = delta + to - from;
    let distance = gap.length();
    let of_ring = || CurvePoint { along: a.axis.cross(toward), end: None };
    let points = || [of_ring(), CurvePoint::of_segment(b.axis, b.half, at)];
    let normal = meeting::normal(points, gap, distance, gap, size);
    Nearest { from, to, normal, distance }
}

/// The squared distance at a position along the segment, with half its first and second derivative.
struct Sample {
    square: f64,
    slope: f64,
    bend: f64,
}

/// How the segment's line passes the circle's axis: the position, the distance, and the sine of the angle.
#[derive(Clone, Copy)]
struct Passing {
    turn: f64,
    miss: f64,
    sine: f64,
}

/// Distance from the axis, as a fraction of the sizes, below which it is computed from the line's passing: there the
/// difference of vectors is rounding without a sign, and the slope of `rho` changes sign.
const NEAR_AXIS: f64 = 1e-6;

fn sample(delta: DVec3, a: &Circle, b: Segment, at: f64, side: &Side) -> Sample {
    let p = delta + b.axis * at;
    let (z, z1) = (a.axis.dot(p), a.axis.dot(b.axis));
    let (q, q1) = (p - a.axis * z, b.axis - a.axis * z1);
    let rho = q.length();
    let (rho, rho1, rho2) = if rho > NEAR_AXIS * (a.radius + p.length()) {
        let inverse = 1.0 / rho;
        (rho, q.dot(q1) * inverse, q.cross(q1).length_squared() * inverse * inverse * inverse)
    } else {
        side.near_axis(at)
    };
    let off = rho - a.radius;
    Sample { square: z * z + off * off, slope: z * z1 + off * rho1, bend: z1 * z1 + rho1 * rho1 + off * rho2 }
}

/// A piece of the segment on which the squared distance is convex.
struct Side {
    low: f64,
    high: f64,
    /// Its border towards the point nearest to the axis.
    inner: f64,
    /// -1 before that point, 1 after it: the sign of the slope of `rho` if that point is on the axis itself.
    sign: f64,
    passing: Passing,
}

impl Side {
    /// The distance from the axis and its derivatives at a position.
    fn near_axis(&self, at: f64) -> (f64, f64, f64) {
        let Passing { turn, miss, sine } = self.passing;
        let along = sine * (at - turn);
        let rho = miss.hypot(along);
        if rho == 0.0 {
            return (0.0, self.sign * sine, 0.0);
        }
        let (cosine, aside) = (along / rho, miss / rho);
        (rho, sine * cosine, sine * sine * aside * aside / rho)
    }
}

/// The piece before the point nearest to the axis and the one after it.
fn sides(delta: DVec3, a: &Circle, b: Segment) -> [Side; 2] {
    let lean = across(b.axis, a.axis).unwrap_or(DVec3::ZERO);
    let lean2 = lean.length_squared();
    // A segment along the axis has a constant distance from it; the formulas below hold with any point as the nearest.
    let turn = if lean2 > 0.0 { -delta.dot(lean) / lean2 } else { -delta.dot(b.axis) };
    let off_axis = delta + b.axis * turn;
    let miss2 = across(off_axis, a.axis).map_or(0.0, DVec3::length_squared);
    let passing = Passing { turn, miss: miss2.sqrt(), sine: lean2.sqrt() };
    let concave2 = (a.radius * lean2 * miss2).powf(2.0 / 3.0) - miss2;
    let reach = if lean2 > 0.0 && concave2 > 0.0 { (concave2 / lean2).sqrt() } else { 0.0 };
    // An interior minimum is within R of the foot of the centre: the slope of rho is at most 1.
    let foot = -delta.dot(b.axis);
    let (low, high) = ((foot - a.radius).clamp(-b.half, b.half), (foot + a.radius).clamp(-b.half, b.half));
    let [last, first] = [turn - reach, turn + reach].map(|inner| inner.clamp(low, high));
    let before = Side { low, high: last, inner: last, sign: -1.0, passing };
    [before, Side { low: first, high, inner: first, sign: 1.0, passing }]
}

/// The position along the segment nearest to the circle.
fn place(delta: DVec3, a: &Circle, b: Segment, tie: f64) -> f64 {
    let sides = sides(delta, a, b);
    let [before, after] = [0, 1].map(|k| minimum(delta, a, b, &sides[k]));
    let square = |at: f64| sample(delta, a, b, at, &sides[1]).square.sqrt();
    if square(after) < square(before) - tie { after } else { before }
}

/// The position of the smallest distance in a piece.
fn minimum(delta: DVec3, a: &Circle, b: Segment, side: &Side) -> f64 {
    let (mut low, mut high) = (side.low, side.high);
    let slope = |at: f64| sample(delta, a, b, at, side);
    if slope(low).slope >= 0.0 {
        return low;
    }
    if slope(high).slope <= 0.0 {
        return high;
    }
    let mut at = 0.5 * (low + high);
    for _ in 0..MAX_STEPS {
        let here = slope(at);
        if here.slope <= 0.0 {
            low = at
        } else {
            high = at
        }
        let newton = at - here.slope / here.bend;
        let next = if here.bend > 0.0 && newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let step = (next - at).abs();
        at = next;
        if step <= f64::EPSILON * (low.abs() + high.abs()) {
            break;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use crate::separation::{Placed, separation};
    use crate::shape::Shape;
    use glam::{DQuat, DVec3};

    /// Earlier, the slope of the distance from the axis counted as zero on the axis, and the search stayed there.
    #[test]
    fn a_rod_through_the_axis_in_the_plane_of_a_ring_is_nearest_at_an_end() {
        let ring = Placed {
            shape: Shape::Torus { major_radius: 100.0, minor_radius: 0.1 },
            position: DVec3::ZERO,
            orientation: DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        };
        let rod = Placed {
            shape: Shape::Spherocylinder { diameter: 1.0, length: 5.0 },
            position: DVec3::Z,
            orientation: DQuat::IDENTITY,
        };
        // The upper end of the rod's segment is at z = 3, in the ring's plane.
        let found = separation(&ring, &rod, None).expect("supported");
        assert!((found.separation - (100.0 - 3.0 - 0.1 - 0.5)).abs() < 1e-9, "{found:?}");
    }
}
