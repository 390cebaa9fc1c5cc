//! The largest of `f(n) = n . Delta - sum of h(n)` over unit normals: Newton on the sphere, safeguarded.
//!
//! Across `n` the gradient is `Delta - sum of y` and the Hessian `-(sum of H) - f`, since `n . grad f = f`. It is
//! negative definite wherever `f > -rho`, with `rho` the sum of the bodies' least radii of curvature: shrink each body
//! by its ball, then `f + rho` is the same function of the shrunken bodies, concave and positively homogeneous, so at
//! most one maximum is above `-rho`. A step that does not raise `f` is shortened.
//!
//! It is written over the trait [`Supporting`], which ellipsoids and custom shapes implement. Bodies with flat places
//! are climbed in `flat`.

use super::flat;
use glam::DVec3;

/// A body about the origin: the functions on which the maximum depends.
pub(super) trait Supporting: Copy {
    /// The support function at a unit normal, and the surface point whose outward normal it is.
    fn value_and_point(self, normal: DVec3) -> (f64, DVec3);
    /// The Hessian across the normal in a tangent basis, as (11, 12, 22), given the value there.
    fn hessian(self, normal: DVec3, value: f64, basis: (DVec3, DVec3)) -> (f64, f64, f64);
    /// Its largest extent from the centre.
    fn size(self) -> f64;
    /// The ratio of its largest to its smallest size.
    fn aspect(self) -> f64;
    /// The part of the way from the centre to the surface at which a point is, and the outward normal where the ray
    /// through it leaves the body; `None` where it is not known.
    fn gauge(self, _point: DVec3) -> Option<(f64, DVec3)> {
        None
    }
    /// Whether it has places without curvature, and is climbed as such a body.
    fn is_flat(self) -> bool {
        false
    }
    /// Whether it has edges and corners, and so many maxima.
    fn has_edges(self) -> bool {
        false
    }
}

/// The largest number of steps. Over thousands of random poses in contact range none took more than 3 at aspect ratio
/// 2, 12 at 100 and 53 at 1000; with deep overlap, from every start, up to 128.
pub(super) const MAX_STEPS: usize = 400;
/// Gradient, as a fraction of the sizes, that is rounding.
pub(super) const GRADIENT_FLOOR: f64 = 4e-16;
/// Change in `f`, as a fraction of the sizes, that is rounding.
pub(super) const VALUE_FLOOR: f64 = 1e-15;
/// Longest step across the normal: 45 degrees once projected back.
pub(super) const LONGEST_STEP: f64 = 1.0;
/// Ratio of the smallest to the largest eigenvalue below which a Hessian counts as singular: above the rounding of
/// 1e-16, below the 1e-9 or more of the most slender bodies supported.
const DEFINITE: f64 = 1e-13;
/// The factor by which a failed step is shortened.
pub(super) const SHORTEN: f64 = 0.25;

/// A local maximum: the normal, `f` there, and the bodies' points with that outward normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peak<const N: usize> {
    pub normal: DVec3,
    pub value: f64,
    pub points: [DVec3; N],
    pub heights: [f64; N],
}

impl<const N: usize> Peak<N> {
    /// `f` and its points at one normal.
    #[inline]
    pub fn at(delta: DVec3, bodies: &[impl Supporting; N], normal: DVec3) -> Self {
        let supports = bodies.map(|body| body.value_and_point(normal));
        let value = normal.dot(delta) - supports.iter().map(|s| s.0).sum::<f64>();
        Peak { normal, value, points: supports.map(|s| s.1), heights: supports.map(|s| s.0) }
    }

    /// Normal of the maximum of the function that bounds `f` from below with squares in place of the `h`, touching at
    /// this normal: `n ~ (sum of M M^T / h + f)^-1 Delta`. It is exact at the maximum, and it reaches the right
    /// neighbourhood in few steps where Newton would zigzag across the edge of a flat body.
    #[inline]
    pub fn majorized(&self, delta: DVec3, squares: &[glam::DMat3; N]) -> Option<DVec3> {
        let mut matrix = glam::DMat3::from_diagonal(DVec3::splat(self.value.max(0.0)));
        for (square, height) in squares.iter().zip(self.heights) {
            matrix += *square * (1.0 / height);
        }
        let [u, v, w] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        DVec3::new(v.cross(w).dot(delta), w.cross(u).dot(delta), u.cross(v).dot(delta)).try_normalize()
    }

    #[inline]
    pub fn gradient(&self, delta: DVec3, (e1, e2): (DVec3, DVec3)) -> (f64, f64) {
        let gap = delta - self.points.iter().sum::<DVec3>();
        (gap.dot(e1), gap.dot(e2))
    }
}

/// The Newton step in a tangent basis from the gradient and the negated Hessian, which is shifted if it is not positive
/// definite, so that the step still ascends.
#[inline]
pub(super) fn newton_step((g1, g2): (f64, f64), (h11, h12, h22): (f64, f64, f64)) -> (f64, f64) {
    let mean = 0.5 * (h11 + h22);
    let spread = (0.5 * (h11 - h22)).hypot(h12);
    let definite = mean - spread > DEFINITE * spread;
    let shift = if definite { 0.0 } else { spread - mean + DEFINITE * spread + g1.hypot(g2) };
    let (h11, h22) = (h11 + shift, h22 + shift);
    let determinant = h11 * h22 - h12 * h12;
    let (s1, s2) = ((h22 * g1 - h12 * g2) / determinant, (h11 * g2 - h12 * g1) / determinant);
    let length = s1.hypot(s2);
    let scale = if length > LONGEST_STEP { LONGEST_STEP / length } else { 1.0 };
    (s1 * scale, s2 * scale)
}

/// Ascends from `start` (a unit vector) to a local maximum.
pub(super) fn climb<const N: usize>(delta: DVec3, bodies: &[impl Supporting; N], start: DVec3) -> Peak<N> {
    if bodies.iter().any(|body| body.is_flat()) {
        return flat::climb(delta, bodies, start);
    }
    let mut peak = Peak::at(delta, bodies, start);
    let size = delta.length() + bodies.iter().map(|b| b.size()).sum::<f64>();
    let aspect = bodies.iter().map(|b| b.aspect()).fold(1.0, f64::max);
    for _ in 0..MAX_STEPS {
        let basis = peak.normal.any_orthonormal_pair();
        let gradient = peak.gradient(delta, basis);
        let slope = gradient.0.hypot(gradient.1);
        if slope <= GRADIENT_FLOOR * size {
            break;
        }
        let mut hessian = (peak.value, 0.0, peak.value);
        for (body, height) in bodies.iter().zip(peak.heights) {
            let h = body.hessian(peak.normal, height, basis);
            hessian = (hessian.0 + h.0, hessian.1 + h.1, hessian.2 + h.2);
        }
        let step = newton_step(gradient, hessian);
        let Some(next) = advance(delta, bodies, &peak, basis, gradient, step, size) else { break };
        peak = next;
        // Newton's error is quadratic, with the curvature changing over an angle of one over the aspect ratio.
        if slope * step.0.hypot(step.1) * aspect <= GRADIENT_FLOOR * size {
            break;
        }
    }
    peak
}

/// The first of the steps 1, 1/4, 1/16 ... that raises `f`, or lowers the gradient if the change of `f` is rounding;
/// `None` if no step does.
#[inline]
fn advance<const N: usize>(
    delta: DVec3,
    bodies: &[impl Supporting; N],
    peak: &Peak<N>,
    (e1, e2): (DVec3, DVec3),
    (g1, g2): (f64, f64),
    (s1, s2): (f64, f64),
    size: f64,
) -> Option<Peak<N>> {
    let mut fraction = 1.0;
    let gain = g1 * s1 + g2 * s2;
    loop {
        let normal = (peak.normal + (e1 * s1 + e2 * s2) * fraction).normalize();
        let next = Peak::at(delta, bodies, normal);
        let visible = gain * fraction > VALUE_FLOOR * size;
        if visible && next.value > peak.value {
            return Some(next);
        }
        if !visible {
            let (n1, n2) = next.gradient(delta, normal.any_orthonormal_pair());
            let calmer = n1.hypot(n2) < g1.hypot(g2) && next.value >= peak.value - VALUE_FLOOR * size;
            return calmer.then_some(next);
        }
        fraction *= SHORTEN;
    }
}

/// As [`climb`], for one body and only over normals at right angles to the unit vector `axis`, of which `start` is one.
pub(super) fn climb_across(delta: DVec3, body: impl Supporting, axis: DVec3, start: DVec3) -> Peak<1> {
    if body.is_flat() {
        return flat::climb_across(delta, body, axis, start);
    }
    let size = delta.length() + body.size();
    let slope_of = |peak: &Peak<1>| axis.cross(peak.normal).dot(delta - peak.points[0]);
    let mut peak = Peak::at(delta, &[body], start);
    'steps: for _ in 0..MAX_STEPS {
        let (along, slope) = (axis.cross(peak.normal), slope_of(&peak));
        if slope.abs() <= GRADIENT_FLOOR * size {
            break;
        }
        let bend = peak.value + body.hessian(peak.normal, peak.heights[0], (along, axis)).0;
        let newton = if bend > 0.0 { slope / bend } else { LONGEST_STEP.copysign(slope) };
        let mut step = newton.clamp(-LONGEST_STEP, LONGEST_STEP);
        let last = slope * step * body.aspect() <= GRADIENT_FLOOR * size;
        loop {
            let next = Peak::at(delta, &[body], (peak.normal + along * step).normalize());
            let visible = slope * step > VALUE_FLOOR * size;
            let calmer = slope_of(&next).abs() < slope.abs() && next.value >= peak.value - VALUE_FLOOR * size;
            if if visible { next.value > peak.value } else { calmer } {
                peak = next;
                break;
            }
            if !visible {
                break 'steps;
            }
            step *= SHORTEN;
        }
        if last {
            break;
        }
    }
    peak
}
