//! A circle and an ellipsoid or custom shape: the least signed distance of the circle's points to the body.
//!
//! The unknown is the angle along the circle. The distance `phi` of a point to a convex body, negative inside, is a
//! convex function of the point, and its gradient is the body's normal `n` there. So along a circle of radius `R` its
//! derivative is `n . p'` and its second derivative is at least `-R`, also inside, where it has kinks. Two parabolas
//! with that bend bound it from below between two samples; an interval where they stay above what is wanted is skipped.
//! Of the others, one is halved while it may contain two minima, by the derivatives at its ends; a safeguarded Newton
//! method finds the minimum in the rest. Everything is in the body's axes, where a normal's small components keep their
//! digits.
//!
//! With `H` the Hessian of the support function, that of the distance is `(H + phi)^-1` across the normal.
//!
//! Degenerate cases: a constant distance, as of a coaxial body of revolution (the first sample, and no minimum); equal
//! minima (the first); a point with several nearest ones (see `point_ellipsoid` and `segment_convex`).

use super::circles::{Circle, MAX_HALVINGS, TIE, roots_between};
use super::convex::Body;
use super::peak::Supporting;
use super::{Separation, circles};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Samples on the circle.
const SAMPLES: usize = 32;
/// The largest number of steps of the refinement, and after how many of them every other one halves the bracket: at a
/// kink, which is inside the body, Newton's steps need not.
const MAX_STEPS: usize = 100;
const FAST_STEPS: usize = 10;

/// The distance of the circle's point at an angle, its two derivatives, and the rounding error of the first.
#[derive(Clone, Copy)]
struct Sample {
    angle: f64,
    value: f64,
    slope: f64,
    curvature: f64,
    rounding: f64,
}

/// A circle in the axes of a body about the origin: its centre, and two perpendicular radii.
struct Around {
    body: Body,
    centre: DVec3,
    first: DVec3,
    second: DVec3,
    radius: f64,
    size: f64,
}

impl Around {
    fn new(centre: DVec3, circle: &Circle, body: Body) -> (Around, DMat3) {
        let (body, axes) = body.in_own_axes();
        let in_axes = |v: DVec3| DVec3::new(axes.x_axis.dot(v), axes.y_axis.dot(v), axes.z_axis.dot(v));
        let around = Around {
            body,
            centre: in_axes(centre),
            first: in_axes(circle.first) * circle.radius,
            second: in_axes(circle.second) * circle.radius,
            radius: circle.radius,
            size: centre.length() + circle.radius + body.size(),
        };
        (around, axes)
    }

    /// The radius to the circle's point at an angle, and its derivative.
    fn arm(&self, angle: f64) -> (DVec3, DVec3) {
        let (sine, cosine) = angle.sin_cos();
        (self.first * cosine + self.second * sine, self.second * cosine - self.first * sine)
    }

    fn sample(&self, angle: f64) -> Sample {
        let (out, p1) = self.arm(angle);
        let p = self.centre + out;
        let normal = self.body.normal_nearest_to(p);
        let height = self.body.value_and_point(normal).0;
        let value = normal.dot(p) - height;
        let bends = self.bends(normal, height, value);
        let mut curvature = -normal.dot(out);
        let mut swing = 0.0;
        for (direction, radius) in bends {
            let along = p1.dot(direction);
            curvature += along * along / radius;
            swing += along.abs() / radius;
        }
        let rounding = 2.0 * f64::EPSILON * (self.radius + self.size * swing);
        Sample { angle, value, slope: normal.dot(p1), curvature, rounding }
    }

    /// The two directions across a normal in which the body is curved most and least, each with the radius of curvature
    /// of the body grown by `value`, which is positive up to rounding.
    fn bends(&self, normal: DVec3, height: f64, value: f64) -> [(DVec3, f64); 2] {
        let (e1, e2) = normal.any_orthonormal_pair();
        let (h11, h12, h22) = self.body.hessian(normal, height, (e1, e2));
        let turn = DVec2::from_angle(0.5 * (2.0 * h12).atan2(h11 - h22));
        let (e1, e2) = (e1 * turn.x + e2 * turn.y, e2 * turn.x - e1 * turn.y);
        let (h11, _, h22) = self.body.hessian(normal, height, (e1, e2));
        let least = f64::EPSILON * f64::EPSILON * self.size;
        [(e1, (h11 + value).max(least)), (e2, (h22 + value).max(least))]
    }

    /// A lower bound of the distance between two samples: the crossing of the parabolas from both, and what their arc
    /// allows.
    fn bound(&self, low: &Sample, high: &Sample) -> f64 {
        let (turn, radius) = (high.angle - low.angle, self.radius);
        let by_arc = 0.5 * (low.value + high.value - radius * turn);
        let along = low.slope - high.slope - radius * turn;
        let at = (high.value - low.value - high.slope * turn - 0.5 * radius * turn * turn) / along;
        if !(at > 0.0 && at < turn) {
            return low.value.min(high.value);
        }
        by_arc.max(low.value + low.slope * at - 0.5 * radius * at * at).min(low.value.min(high.value))
    }

    /// Searches for minima along the whole circle, unless the distance is constant. Returns the nearest sample, the
    /// first among equals.
    fn search_all(&self, kept: &mut Kept) -> Sample {
        let around: [Sample; SAMPLES] = std::array::from_fn(|i| self.sample(TAU * i as f64 / SAMPLES as f64));
        let least = around.iter().map(|s| s.value).fold(f64::INFINITY, f64::min);
        let most = around.iter().map(|s| s.value).fold(f64::NEG_INFINITY, f64::max);
        if most - least <= TIE * self.size {
            return around[0];
        }
        kept.most = kept.most.min(if kept.wanted == 1 { least } else { f64::INFINITY });
        for i in 0..SAMPLES {
            let next = Sample { angle: TAU * (i + 1) as f64 / SAMPLES as f64, ..around[(i + 1) % SAMPLES] };
            self.search((around[i], next), MAX_HALVINGS, kept);
        }
        around.into_iter().reduce(|m, s| if s.value < m.value { s } else { m }).unwrap_or(around[0])
    }

    /// Searches for minima between two samples.
    fn search(&self, (low, high): (Sample, Sample), halvings: usize, kept: &mut Kept) {
        if self.bound(&low, &high) > kept.most + kept.tie {
            return;
        }
        let bracket = low.slope <= 0.0 && high.slope > 0.0;
        let open = halvings > 0 && !is_resolved(&low, &high);
        if !open && !bracket {
            return;
        }
        let middle = self.sample(0.5 * (low.angle + high.angle));
        if open || halvings > 0 && !(is_resolved(&low, &middle) && is_resolved(&middle, &high)) {
            self.search((low, middle), halvings - 1, kept);
            self.search((middle, high), halvings - 1, kept);
        } else {
            kept.found(self.refine((low, middle, high)));
        }
    }

    /// The root of the slope in a bracket, by Newton's method, or by halving.
    fn refine(&self, (low, middle, high): (Sample, Sample, Sample)) -> Sample {
        let (mut left, mut right) = (low.angle, high.angle);
        let mut here = middle;
        for step in 0..MAX_STEPS {
            if here.slope.abs() <= here.rounding {
                break;
            }
            if here.slope <= 0.0 {
                left = here.angle
            } else {
                right = here.angle
            }
            let newton = here.angle - here.slope / here.curvature;
            let fast = step < FAST_STEPS || step % 2 == 0;
            let inside = fast && here.curvature > 0.0 && newton > left && newton < right;
            let angle = if inside { newton } else { 0.5 * (left + right) };
            if (angle - here.angle).abs() <= 4.0 * f64::EPSILON {
                break;
            }
            here = self.sample(angle);
        }
        here
    }
}

/// Whether an interval has at most one root of the slope, or a slope that is rounding.
fn is_resolved(low: &Sample, high: &Sample) -> bool {
    let (flat, once) = roots_between([low, high].map(|of| [of.angle, of.slope, of.curvature, of.rounding]));
    flat || once
}

/// The minima that a search keeps: the nearest one, or the nearest few with a distance of at most `most`.
struct Kept {
    wanted: usize,
    most: f64,
    tie: f64,
    minima: Vec<Sample>,
}

impl Kept {
    fn new(wanted: usize, most: f64, around: &Around) -> Kept {
        Kept { wanted, most, tie: TIE * around.size, minima: Vec::with_capacity(wanted) }
    }

    fn found(&mut self, minimum: Sample) {
        if self.wanted > 1 && minimum.value > self.most {
            return;
        }
        if self.minima.len() < self.wanted {
            self.minima.push(minimum);
        } else if let Some(farthest) = self.minima.iter_mut().reduce(|m, s| if s.value > m.value { s } else { m })
            && minimum.value < farthest.value - self.tie
        {
            *farthest = minimum;
        }
        if self.wanted == 1 {
            self.most = self.most.min(self.minima[0].value);
        }
    }
}

/// The separation of the circle about the origin, thickened by `radius`, and the body about `delta`.
pub(super) fn separation(delta: DVec3, (circle, radius): (Circle, f64), body: Body) -> Separation {
    let (around, axes) = Around::new(-delta, &circle, body);
    let mut kept = Kept::new(1, f64::INFINITY, &around);
    let nearest = around.search_all(&mut kept);
    at_angle(&around, axes, kept.minima.first().unwrap_or(&nearest).angle, radius)
}

/// The separation at every minimum of the distance along the circle that is at most `most`, in the order of their
/// angles; of more than [`circles::MINIMA`], the nearest.
pub(super) fn minima(
    delta: DVec3,
    (circle, radius): (Circle, f64),
    body: Body,
    most: f64,
    mut found: impl FnMut(Separation),
) {
    let (around, axes) = Around::new(-delta, &circle, body);
    let mut kept = Kept::new(circles::MINIMA, most + radius, &around);
    around.search_all(&mut kept);
    kept.minima.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    for minimum in kept.minima {
        found(at_angle(&around, axes, minimum.angle, radius));
    }
}

fn at_angle(around: &Around, axes: DMat3, angle: f64, radius: f64) -> Separation {
    let out = around.arm(angle).0;
    let p = around.centre + out;
    let outward = around.body.normal_nearest_to(p);
    let (height, mut point) = around.body.value_and_point(outward);
    let value = outward.dot(p) - height;
    if around.body.is_flat() {
        // A flat place's point is known to a root of rounding, the circle's well.
        point = p - outward * value;
    }
    Separation {
        separation: value - radius,
        normal: axes * -outward,
        lever_a: axes * (out - outward * radius),
        lever_b: axes * point,
    }
}
