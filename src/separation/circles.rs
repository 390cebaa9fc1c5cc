//! Two circles: the nearest points of two circles in space.
//!
//! The point of circle a nearest to a given point has a closed form; the unknown is the angle `theta` along circle b.
//! With `z` the height of its point over the plane of a and `rho` its distance from the axis of a, the squared distance
//! is `z^2 + (rho - R_a)^2`, a sum of squares that keeps its digits as the circles meet. Samples bracket all its minima
//! over `theta`, and a safeguarded Newton method refines the smallest one, or each within some distance. Circle b is
//! the smaller one, so that two samples do not skip a feature of the other.
//!
//! An interval is halved while it may contain two minima, by its first and second derivatives, or while it is wide
//! compared with its distance from the axis of a, where the function is not smooth. An interval is skipped if, by the
//! length of its arc, it cannot contain a wanted minimum.
//!
//! Degenerate cases: coaxial circles and others with a constant distance (the first sample, and no minimum); circles
//! that meet (`meeting`); a point on the axis up to rounding (the first direction in the plane); equal minima (the
//! first).

use super::Nearest;
use super::direction::across;
use super::meeting::{self, CurvePoint};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// A circle about the origin, with two directions in its plane and its normal.
#[derive(Clone, Copy)]
pub(super) struct Circle {
    pub radius: f64,
    pub first: DVec3,
    pub second: DVec3,
    pub axis: DVec3,
}

/// Samples on the circle. Over a million poses, half of them random and half nearly coaxial, with radii up to 100:1,
/// turning the pair (which changes the samples) changes the distance by at most 2e-11 of the size. With 24, and the
/// looser [`MONOTONE`] of 3, a few in a million lost up to 1e-4; 32 with that looser value lost 1e-9.
const SAMPLES: usize = 32;
/// Distances this close, as a fraction of the sizes, are equal.
pub(super) const TIE: f64 = 1e-13;
/// Ratio of the second derivatives at the ends of an interval below which the first derivative counts as monotone
/// between them.
const MONOTONE: f64 = 2.0;
/// The largest number of distinct minima. Linked rings of a stretched sheet have two.
pub(super) const MINIMA: usize = 4;
/// The largest number of steps of the refinement; each at least halves the bracket.
const MAX_STEPS: usize = 60;
/// The largest number of halvings of an interval: a minimum hidden in the last has a width of 1e-9, and is nearer by at
/// most its square.
pub(super) const MAX_HALVINGS: usize = 26;

/// Sines and cosines of the samples' angles.
static AROUND: LazyLock<[(f64, f64); SAMPLES]> = LazyLock::new(|| std::array::from_fn(|i| angle_of(i).sin_cos()));

/// The angle of a sample.
#[inline]
fn angle_of(sample: usize) -> f64 {
    TAU * sample as f64 / SAMPLES as f64
}

impl Circle {
    #[inline]
    pub fn new(radius: f64, orientation: DQuat) -> Circle {
        let axes = glam::DMat3::from_quat(orientation);
        Circle { radius, first: axes.x_axis, second: axes.y_axis, axis: axes.z_axis }
    }

    /// The direction from the centre, and along the circle, at the angle with this sine and cosine.
    #[inline]
    fn frame(&self, (sine, cosine): (f64, f64)) -> (DVec3, DVec3) {
        (self.first * cosine + self.second * sine, self.second * cosine - self.first * sine)
    }

    /// The unit direction, in the plane, from the centre to the circle's point nearest to `p`; the first direction if
    /// `p` is on the axis.
    #[inline]
    pub fn toward(&self, p: DVec3) -> DVec3 {
        across(p, self.axis).and_then(DVec3::try_normalize).unwrap_or(self.first)
    }
}

/// The squared distance at an angle, its first and second derivative, and the rounding error of the first.
#[derive(Clone, Copy)]
struct Sample {
    angle: f64,
    square: f64,
    slope: f64,
    curvature: f64,
    rounding: f64,
    rho: f64,
    rho1: f64,
}

/// Circle b in the axes of circle a, whose normal is z: its centre, and two perpendicular radii.
struct Posed {
    centre: DVec3,
    first: DVec3,
    second: DVec3,
    radius_a: f64,
    radius_b: f64,
}

impl Posed {
    /// Circle `b` about `delta`.
    fn new(delta: DVec3, a: &Circle, b: &Circle) -> Posed {
        let in_axes = |v: DVec3| DVec3::new(a.first.dot(v), a.second.dot(v), a.axis.dot(v));
        Posed {
            centre: in_axes(delta),
            first: in_axes(b.first * b.radius),
            second: in_axes(b.second * b.radius),
            radius_a: a.radius,
            radius_b: b.radius,
        }
    }

    /// The squared distance from circle a at an angle along b.
    #[inline]
    fn sample(&self, angle: f64) -> Sample {
        self.sample_at(angle, angle.sin_cos())
    }

    /// The same for an angle with this sine and cosine.
    #[inline]
    fn sample_at(&self, angle: f64, (sine, cosine): (f64, f64)) -> Sample {
        let (out, p1) = (self.first * cosine + self.second * sine, self.second * cosine - self.first * sine);
        let p = self.centre + out;
        let rho = (p.x * p.x + p.y * p.y).sqrt();
        let inverse = if rho > 0.0 { 1.0 / rho } else { 0.0 };
        let rho1 = (p.x * p1.x + p.y * p1.y) * inverse;
        let spin = (p.x * p1.y - p.y * p1.x) * inverse;
        let rho2 = (spin * spin - (p.x * out.x + p.y * out.y)) * inverse;
        let off = rho - self.radius_a;
        let size = self.radius_a + self.radius_b + p.z.abs();
        Sample {
            angle,
            square: p.z * p.z + off * off,
            slope: 2.0 * (p.z * p1.z + off * rho1),
            curvature: 2.0 * (p1.z * p1.z - p.z * out.z + rho1 * rho1 + off * rho2),
            rounding: 2.0 * f64::EPSILON * (size * (p1.z.abs() + rho1.abs()) + self.radius_b * (p.z.abs() + off.abs())),
            rho,
            rho1,
        }
    }
}

/// The minima that a search keeps, in the order of their angles.
trait Kept {
    /// Receives the distance of the nearest sample.
    fn begin(&mut self, nearest: f64);
    /// The distance above which no minimum is kept.
    fn most(&self) -> f64;
    /// Receives a minimum, and may keep it.
    fn found(&mut self, minimum: Sample);
}

/// The nearest minimum, the first among equals.
struct Least {
    best: Option<Sample>,
    tie: f64,
    /// The distance of the nearest sample: a bound until a minimum is found.
    sampled: f64,
}

impl Kept for Least {
    #[inline]
    fn begin(&mut self, nearest: f64) {
        self.sampled = nearest;
    }

    #[inline]
    fn most(&self) -> f64 {
        self.best.map_or(self.sampled, |best| best.square.sqrt())
    }

    #[inline]
    fn found(&mut self, minimum: Sample) {
        if self.best.is_none_or(|best| minimum.square.sqrt() < best.square.sqrt() - self.tie) {
            self.best = Some(minimum);
        }
    }
}

/// The first minima with a distance of at most `most`.
struct Within {
    most: f64,
    angles: [f64; MINIMA],
    count: usize,
}

impl Kept for Within {
    fn begin(&mut self, _: f64) {}

    fn most(&self) -> f64 {
        self.most
    }

    fn found(&mut self, minimum: Sample) {
        if minimum.square.sqrt() <= self.most && self.count < MINIMA {
            self.angles[self.count] = minimum.angle;
            self.count += 1;
        }
    }
}

/// Nearest points of circle `a` about the origin and circle `b` about `delta`.
pub(super) fn nearest(delta: DVec3, a: Circle, b: Circle) -> Nearest {
    let size = delta.length() + a.radius + b.radius;
    let mut kept = Least { best: None, tie: TIE * size, sampled: f64::INFINITY };
    let start = search_all(&Posed::new(delta, &a, &b), size, &mut kept);
    at_angle(delta, &a, &b, kept.best.unwrap_or(start).angle, size)
}

/// The nearest points at every minimum of the distance along circle `b` that is at most `most`, in the order of their
/// angles on it, [`MINIMA`] at most. Circles with a constant distance have none.
pub(super) fn minima(delta: DVec3, a: Circle, b: Circle, most: f64, mut found: impl FnMut(Nearest)) {
    let size = delta.length() + a.radius + b.radius;
    let mut kept = Within { most, angles: [0.0; MINIMA], count: 0 };
    search_all(&Posed::new(delta, &a, &b), size, &mut kept);
    for angle in &kept.angles[..kept.count] {
        found(at_angle(delta, &a, &b, *angle, size));
    }
}

/// Searches for minima along the whole circle, unless the distance is constant. Returns the nearest sample, the first
/// among equals.
fn search_all(circles: &Posed, size: f64, kept: &mut impl Kept) -> Sample {
    let sines = &*AROUND;
    let around: [Sample; SAMPLES] = std::array::from_fn(|i| circles.sample_at(angle_of(i), sines[i]));
    let least = around.iter().map(|s| s.square).fold(f64::INFINITY, f64::min);
    let most = around.iter().map(|s| s.square).fold(0.0, f64::max);
    if most.sqrt() - least.sqrt() <= TIE * size {
        return around[0];
    }
    kept.begin(least.sqrt());
    for i in 0..SAMPLES {
        let next = Sample { angle: angle_of(i + 1), ..around[(i + 1) % SAMPLES] };
        search(circles, (around[i], next), MAX_HALVINGS, kept);
    }
    around.into_iter().reduce(|m, s| if s.square < m.square { s } else { m }).unwrap_or(around[0])
}

/// Searches for minima between two samples.
fn search(circles: &Posed, (low, high): (Sample, Sample), halvings: usize, kept: &mut impl Kept) {
    let arc = circles.radius_b * (high.angle - low.angle);
    let reach = low.square.min(high.square).sqrt() - 0.5 * arc;
    if reach > kept.most() {
        return;
    }
    let bracket = low.slope <= 0.0 && high.slope > 0.0;
    let open = halvings > 0 && !is_resolved(&low, &high, arc);
    if !open && !bracket {
        return;
    }
    let middle = circles.sample(0.5 * (low.angle + high.angle));
    if open || halvings > 0 && !(is_resolved(&low, &middle, arc) && is_resolved(&middle, &high, arc)) {
        search(circles, (low, middle), halvings - 1, kept);
        search(circles, (middle, high), halvings - 1, kept);
    } else {
        kept.found(refine(circles, (low, middle, high)));
    }
}

/// An end of an interval of angles: the angle, the slope there, its derivative, and its rounding error.
pub(super) type End = [f64; 4];

/// Whether a slope is rounding at both ends of an interval; and whether it has at most one root between them, judged
/// from there: it changes in the same direction at both and about as fast, or is too steep to return.
pub(super) fn roots_between([low, high]: [End; 2]) -> (bool, bool) {
    let [[from, low, low_bend, low_rounding], [to, high, high_bend, high_rounding]] = [low, high];
    let bends = (low_bend.abs().min(high_bend.abs()), low_bend.abs().max(high_bend.abs()));
    let monotone = low_bend * high_bend > 0.0 && bends.1 < MONOTONE * bends.0;
    let steep = low * high > 0.0 && low.abs().min(high.abs()) > (to - from) * bends.1;
    (low.abs() <= low_rounding && high.abs() <= high_rounding, monotone || steep)
}

/// Whether an interval has at most one root of the slope. Never if the interval is as wide as the distance of the
/// circle from the axis.
fn is_resolved(low: &Sample, high: &Sample, arc: f64) -> bool {
    let swing = (high.angle - low.angle) * (low.rho1.abs().max(high.rho1.abs()) + arc);
    let smooth = low.rho.min(high.rho) >= swing;
    let (flat, once) = roots_between([low, high].map(|of| [of.angle, of.slope, of.curvature, of.rounding]));
    flat || smooth && once
}

/// The root of the slope in a bracket, by Newton's method, or by halving if Newton leaves the bracket.
fn refine(circles: &Posed, (low, middle, high): (Sample, Sample, Sample)) -> Sample {
    let (mut left, mut right) = (low.angle, high.angle);
    let mut here = middle;
    for _ in 0..MAX_STEPS {
        if here.slope.abs() <= here.rounding {
            break;
        }
        if here.slope <= 0.0 {
            left = here.angle
        } else {
            right = here.angle
        }
        let newton = here.angle - here.slope / here.curvature;
        let inside = here.curvature > 0.0 && newton > left && newton < right;
        let angle = if inside { newton } else { 0.5 * (left + right) };
        let step = (angle - here.angle).abs();
        here = circles.sample(angle);
        if step <= 4.0 * f64::EPSILON {
            break;
        }
    }
    here
}

/// The nearest points for an angle along b.
fn at_angle(delta: DVec3, a: &Circle, b: &Circle, angle: f64, size: f64) -> Nearest {
    let (out, along) = b.frame(angle.sin_cos());
    let to = out * b.radius;
    let toward = a.toward(delta + to);
    let from = toward * a.radius;
    let gap = delta + to - from;
    let distance = gap.length();
    let points = || [a.axis.cross(toward), along].map(|along| CurvePoint { along, end: None });
    let normal = meeting::normal(points, gap, distance, gap, size);
    Nearest { from, to, normal, distance }
}
