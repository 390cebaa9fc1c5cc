//! What a separation must be, by an oracle that knows no special case: it samples and refines, it never makes a
//! direction from a difference, and it does not ask what the placement is.
//!
//! * Of two centrelines the least distance of a point of one from the other, over all places on the first.
//! * Of convex bodies no direction has a larger value of `n . Delta - h_a(n) - h_b(-n)` than the separation.
//!
//! The rest holds of what was found: the value at the normal is the separation, the normal has length one and is at
//! right angles to the centrelines where they go on, the levers lie on the surfaces and `p_b - p_a = Phi n`.

use glam::{DMat3, DVec3};
use rand_chacha::ChaCha8Rng;
use relcp::separation::{Placed, Separation};
use relcp::shape::Shape;
use std::f64::consts::TAU;

use super::placements::turn;

/// How far a found separation is from right; all but `normal` as fractions of the sizes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    pub separation: f64,
    /// The normal's length off one, or how far it leans along a centreline.
    pub normal: f64,
    /// The levers off the surfaces, or from each other by other than the separation along the normal.
    pub lever: f64,
}

impl Errors {
    /// The larger of each; what is not a number counts as the largest.
    pub fn max(self, other: Errors) -> Errors {
        let max = |a: f64, b: f64| if b.is_nan() || a.is_nan() { f64::INFINITY } else { a.max(b) };
        Errors {
            separation: max(self.separation, other.separation),
            normal: max(self.normal, other.normal),
            lever: max(self.lever, other.lever),
        }
    }
}

/// A centreline about a body's centre.
#[derive(Clone, Copy)]
pub enum Curve {
    Segment { axis: DVec3, half: f64 },
    Circle { axes: DMat3, radius: f64 },
}

impl Curve {
    /// The centreline of a body and the radius that it is thickened by.
    pub fn of(body: &Placed) -> Option<(Curve, f64)> {
        let axes = DMat3::from_quat(body.orientation);
        match body.shape {
            Shape::Sphere { radius } => Some((Curve::Segment { axis: DVec3::Z, half: 0.0 }, radius)),
            Shape::Spherocylinder { diameter, length } => {
                Some((Curve::Segment { axis: axes.z_axis, half: 0.5 * (length - diameter) }, 0.5 * diameter))
            }
            Shape::Torus { major_radius, minor_radius } => {
                Some((Curve::Circle { axes, radius: major_radius }, minor_radius))
            }
            _ => None,
        }
    }

    /// The point at `t` from 0 to 1.
    pub fn point(&self, t: f64) -> DVec3 {
        match *self {
            Curve::Segment { axis, half } => axis * (half * (2.0 * t - 1.0)),
            Curve::Circle { axes, radius } => {
                let (sine, cosine) = (TAU * t).sin_cos();
                (axes.x_axis * cosine + axes.y_axis * sine) * radius
            }
        }
    }

    /// The distance of a point, without a direction.
    pub fn distance(&self, p: DVec3) -> f64 {
        match *self {
            Curve::Segment { axis, half } => (p - axis * p.dot(axis).clamp(-half, half)).length(),
            Curve::Circle { axes, radius } => {
                let flat = p.dot(axes.x_axis).hypot(p.dot(axes.y_axis));
                p.dot(axes.z_axis).hypot(flat - radius)
            }
        }
    }

    /// How far `out` is from a direction in which one may leave the curve at its point `p`: at right angles to it, or
    /// at an end, unless the place is fixed there, not back along it. An end is one but for `rounding`, a length.
    fn lean(&self, p: DVec3, out: DVec3, is_free: bool, rounding: f64) -> f64 {
        match *self {
            Curve::Segment { half: 0.0, .. } => 0.0,
            Curve::Segment { axis, half } if p.dot(axis).abs() < half - rounding => axis.dot(out).abs(),
            Curve::Segment { .. } if !is_free => 0.0,
            Curve::Segment { axis, .. } => (-out.dot(axis) * p.dot(axis).signum()).max(0.0),
            Curve::Circle { axes, radius } => (axes.z_axis.cross(p) / radius).dot(out).abs(),
        }
    }

    fn extent(&self) -> f64 {
        match *self {
            Curve::Segment { half, .. } => half,
            Curve::Circle { radius, .. } => radius,
        }
    }
}

/// Samples along a curve.
const SAMPLES: usize = 720;

/// The least of a function over 0 to 1: samples, then golden section about each that is lower than its neighbours.
pub fn least(f: impl Fn(f64) -> f64) -> f64 {
    let at = |i: i64| i as f64 / SAMPLES as f64;
    let values: Vec<f64> = (0..=SAMPLES as i64).map(|i| f(at(i))).collect();
    let sampled = values.iter().copied().fold(f64::INFINITY, f64::min);
    let step = (1..values.len()).map(|i| (values[i] - values[i - 1]).abs()).fold(0.0, f64::max);
    let mut best = sampled;
    for i in 0..=SAMPLES as i64 {
        let here = values[i as usize];
        let [before, after] = [(i - 1).max(0), (i + 1).min(SAMPLES as i64)];
        if here <= values[before as usize] && here <= values[after as usize] && here <= sampled + 2.0 * step {
            best = best.min(golden(&f, at(before), at(after)));
        }
    }
    best
}

fn golden(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut p, mut q) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_p, mut at_q) = (f(p), f(q));
    let mut best = at_p.min(at_q);
    for _ in 0..75 {
        if at_p <= at_q {
            (high, q, at_q) = (q, p, at_p);
            p = high - ratio * (high - low);
            at_p = f(p);
        } else {
            (low, p, at_p) = (p, q, at_q);
            q = low + ratio * (high - low);
            at_q = f(q);
        }
        best = best.min(at_p).min(at_q);
    }
    best
}

/// The support function of a convex body at a unit vector.
pub fn support(body: &Placed, n: DVec3) -> f64 {
    let local = DMat3::from_quat(body.orientation).transpose() * n;
    match body.shape {
        Shape::Sphere { radius } => radius,
        Shape::Spherocylinder { diameter, length } => 0.5 * (length - diameter) * local.z.abs() + 0.5 * diameter,
        Shape::Ellipsoid { radii } => (DVec3::from_array(radii) * local).length(),
        Shape::Convex(shape) => shape.reach(local),
        Shape::Superellipsoid(of) => {
            let [m1, m2] = of.exponents().map(|n| n / (n - 1.0));
            let v = (DVec3::from_array(of.radii()) * local).abs();
            ((v.x.powf(m2) + v.y.powf(m2)).powf(m1 / m2) + v.z.powf(m1)).powf(1.0 / m1)
        }
        other => panic!("{other:?} is not convex"),
    }
}

/// Unit vectors: evenly over the sphere, and over the surfaces of the bodies, whose normals crowd at flat sides.
fn normals(bodies: &[Placed; 2], random: &mut ChaCha8Rng) -> Vec<DVec3> {
    const COUNT: usize = 160;
    let all = DMat3::from_quat(turn(random));
    let even = (0..COUNT).map(|i| {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / COUNT as f64;
        let (sine, cosine) = (i as f64 * 2.399963229728653).sin_cos();
        let across = (1.0 - z * z).sqrt();
        all * DVec3::new(across * cosine, across * sine, z)
    });
    let mut found: Vec<DVec3> = even.clone().collect();
    for body in bodies {
        let axes = DMat3::from_quat(body.orientation);
        found.extend([axes.x_axis, axes.y_axis, axes.z_axis].into_iter().flat_map(|axis| [axis, -axis]));
        let radii = match body.shape {
            Shape::Ellipsoid { radii } => Some(radii),
            Shape::Superellipsoid(of) => Some(of.radii()),
            _ => None,
        };
        if let Some(radii) = radii {
            found.extend(even.clone().map(|u| (axes * (u / DVec3::from_array(radii))).normalize()));
        }
    }
    let between = bodies[1].position - bodies[0].position;
    found.extend([between, -between].into_iter().filter_map(DVec3::try_normalize));
    found
}

/// The largest value over unit normals that samples and a search from the best of them lead to.
fn largest(bodies: &[Placed; 2], found: DVec3, random: &mut ChaCha8Rng) -> f64 {
    let [a, b] = bodies;
    let delta = b.position - a.position;
    let value = |n: DVec3| n.dot(delta) - support(a, n) - support(b, -n);
    let mut tried: Vec<(f64, DVec3)> = normals(bodies, random).into_iter().map(|n| (value(n), n)).collect();
    tried.sort_by(|p, q| q.0.total_cmp(&p.0));
    tried.truncate(4);
    tried.push((value(found), found));
    tried.into_iter().map(|(start, n)| climbed(&value, start, n, 300)).fold(f64::NEG_INFINITY, f64::max)
}

/// Steps to both sides along two tangents and the way last gone, shorter where none leads up.
pub fn climbed(value: &impl Fn(DVec3) -> f64, mut best: f64, mut n: DVec3, steps: usize) -> f64 {
    let (mut width, mut way) = (0.2, DVec3::ZERO);
    for _ in 0..steps {
        let (e1, e2) = n.any_orthonormal_pair();
        let steps = [e1, -e1, e2, -e2, (e1 + e2) * 0.7, (e1 - e2) * 0.7, (e2 - e1) * 0.7, (e1 + e2) * -0.7, way];
        let tried = steps.map(|step| (n + step * width).normalize()).map(|m| (value(m), m));
        let up = tried.into_iter().fold((best, n), |up, one| if one.0 > up.0 { one } else { up });
        if up.0 > best {
            way = (up.1 - n) / width;
            (best, n) = up;
            width *= 1.5;
        } else {
            width *= 0.4;
            if width < 1e-12 {
                break;
            }
        }
    }
    best
}

/// The size that errors are fractions of.
pub fn size([a, b]: &[Placed; 2]) -> f64 {
    a.shape.bounding_radius() + b.shape.bounding_radius() + (b.position - a.position).length()
}

/// The errors of a found separation of two bodies; `rounding` as in [`sound`].
pub fn pair_errors(bodies: &[Placed; 2], found: &Separation, rounding: f64, random: &mut ChaCha8Rng) -> Errors {
    let size = size(bodies);
    let sound = sound(bodies, found, true, rounding);
    let separation = match bodies.each_ref().map(Curve::of) {
        [Some((a, ra)), Some((b, rb))] => {
            let delta = bodies[1].position - bodies[0].position;
            let right = least(|t| a.distance(delta + b.point(t))) - ra - rb;
            (found.separation - right).abs()
        }
        _ => {
            let [a, b] = bodies;
            let n = found.normal;
            let here = n.dot(b.position - a.position) - support(a, n) - support(b, -n);
            (found.separation - here).abs().max(largest(bodies, n, random) - found.separation)
        }
    };
    Errors { separation: separation / size, ..Errors::default() }.max(sound)
}

/// The errors of normal and levers alone, which hold of every branch; `is_free` of the separation itself, which no place
/// is fixed of. A segment's point within `rounding` of the sizes of an end is the end.
pub fn sound(bodies: &[Placed; 2], found: &Separation, is_free: bool, rounding: f64) -> Errors {
    let size = size(bodies);
    let n = found.normal;
    let gap = bodies[1].position - bodies[0].position + found.lever_b - found.lever_a;
    let mut errors = Errors {
        separation: 0.0,
        normal: (n.length() - 1.0).abs(),
        lever: (gap - n * found.separation).length() / size,
    };
    for (body, lever, out) in [(&bodies[0], found.lever_a, n), (&bodies[1], found.lever_b, -n)] {
        let (mut normal, mut off) = (0.0, 0.0);
        if let Some((curve, radius)) = Curve::of(body) {
            let point = lever - out * radius;
            off = curve.distance(point) / size;
            if off < 1e-3 * curve.extent() {
                normal = curve.lean(point, out, is_free, rounding * size);
            }
        } else {
            // A convex body's point is as far along the normal as any.
            off = f64::max(off, (lever.dot(out) - support(body, out)).abs() / size);
        }
        if let Shape::Superellipsoid(of) = body.shape {
            let v = (DMat3::from_quat(body.orientation).transpose() * lever / DVec3::from_array(of.radii())).abs();
            let [n1, n2] = of.exponents();
            let gauge = ((v.x.powf(n2) + v.y.powf(n2)).powf(n1 / n2) + v.z.powf(n1)).powf(1.0 / n1);
            off = f64::max(off, (gauge - 1.0).abs() * body.shape.thickness() / size);
        }
        if let Shape::Ellipsoid { radii } = body.shape {
            let local = DMat3::from_quat(body.orientation).transpose() * lever / DVec3::from_array(radii);
            off = f64::max(off, (local.length() - 1.0).abs() * body.shape.thickness() / size);
        }
        errors = errors.max(Errors { separation: 0.0, normal, lever: off });
    }
    errors
}

/// The errors of a separation of two bodies that cannot leave the plane: no normal in the plane has a larger value.
pub fn planar_errors(bodies: &[Placed; 2], found: &Separation) -> Errors {
    let [a, b] = bodies;
    let size = size(bodies);
    let delta = b.position - a.position;
    let value = |n: DVec3| n.dot(delta) - support(a, n) - support(b, -n);
    let at = |t: f64| -value(DVec3::new((TAU * t).cos(), (TAU * t).sin(), 0.0));
    let right = -least(at);
    let (n, gap) = (found.normal, delta + found.lever_b - found.lever_a);
    Errors {
        separation: (found.separation - value(n)).abs().max((found.separation - right).abs()) / size,
        normal: (n.length() - 1.0).abs().max(n.z.abs()),
        lever: (gap.dot(n) - found.separation).abs() / size,
    }
}
