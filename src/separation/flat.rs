//! The climb of `peak` for bodies that are flat in places, as superellipsoids are where they meet their axes.
//!
//! Near the normal `m` of such a place the support function is `c |n - m|^(1 + 1 / (k - 1))` with `k` the exponent, up
//! to 10: nearly a kink, across which Newton's steps go back and forth. The body's normal is a smooth function of its
//! point there, `|y|^(k - 1)`. So a step also moves the points by what Newton's step says, and tries the normals that
//! the bodies have at those, which is Newton's method for the points. Of the normals tried the one with the largest `f`
//! is taken. Of 300 pairs with faces nearly on each other these steps were 3 on average and 18 at most; those of `peak`
//! alone were 46, and 11 pairs took more than 400.
//!
//! A point on a flat place changes with its normal like a root, by 1e-2 of the size with the rounding of a normal. At
//! the end the points are moved to where they meet along the normal, those of each body by how flat it is; where that
//! is not on the surfaces, by the shares of the gap that are.

use super::peak::{GRADIENT_FLOOR, LONGEST_STEP, MAX_STEPS, Peak, SHORTEN, Supporting, VALUE_FLOOR, newton_step};
use glam::DVec3;

/// A gain in `f`, as a fraction of the sizes, that counts.
const GAIN: f64 = 1e-16;
/// How far off the surface a point may be moved to meet the other, as a part of the way to it: at 0.3 from the middle
/// of a face of exponent 10 the surface is 1e-6 lower.
const OFF: f64 = 1e-4;
/// The shares of the gap between the points of two bodies that the second one's is moved by.
const SHARES: [f64; 5] = [0.5, 0.25, 0.75, 0.0, 1.0];

type Basis = (DVec3, DVec3);
type Hessian = (f64, f64, f64);

/// Ascends from `start` (a unit vector) to a local maximum.
pub(super) fn climb<const N: usize>(delta: DVec3, bodies: &[impl Supporting; N], start: DVec3) -> Peak<N> {
    let size = delta.length() + bodies.iter().map(|b| b.size()).sum::<f64>();
    let mut peak = Peak::at(delta, bodies, start);
    for _ in 0..MAX_STEPS {
        let basis = peak.normal.any_orthonormal_pair();
        let gradient = peak.gradient(delta, basis);
        if gradient.0.hypot(gradient.1) <= GRADIENT_FLOOR * size {
            break;
        }
        let hessians = peak.hessians(bodies, basis);
        let sum = hessians.iter().fold((peak.value, 0.0, peak.value), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
        let step = newton_step(gradient, sum);
        let Some(next) = advance(delta, bodies, &peak, basis, &hessians, (gradient, step), size) else { break };
        peak = next;
    }
    peak.meet(delta, bodies);
    peak
}

/// Takes the best of the normals that a step tries. A step that gains nothing is shortened.
fn advance<const N: usize>(
    delta: DVec3,
    bodies: &[impl Supporting; N],
    peak: &Peak<N>,
    (e1, e2): Basis,
    hessians: &[Hessian; N],
    ((g1, g2), (s1, s2)): ((f64, f64), (f64, f64)),
    size: f64,
) -> Option<Peak<N>> {
    let (gain, mut fraction) = (g1 * s1 + g2 * s2, 1.0);
    loop {
        let mut best = Peak::at(delta, bodies, (peak.normal + (e1 * s1 + e2 * s2) * fraction).normalize());
        for ((body, h), point) in bodies.iter().zip(hessians).zip(peak.points) {
            let moved = e1 * (h.0 * s1 + h.1 * s2) + e2 * (h.1 * s1 + h.2 * s2);
            if let Some((_, normal)) = body.gauge(point + moved * fraction) {
                best = best.or(Peak::at(delta, bodies, normal));
            }
        }
        if best.value > peak.value + GAIN * size {
            return Some(best);
        }
        fraction *= SHORTEN;
        let is_visible = gain * fraction > VALUE_FLOOR * size;
        if !is_visible {
            return None;
        }
    }
}

/// The normal half way between two at which the slope has opposite signs, which takes the place of one of them.
fn halved(
    between: &mut [Option<DVec3>; 2],
    at: impl Fn(DVec3) -> Peak<1>,
    slope_of: impl Fn(&Peak<1>) -> f64,
) -> Option<Peak<1>> {
    let [rising, falling] = *between;
    let middle = at((rising? + falling?).try_normalize()?);
    between[usize::from(slope_of(&middle) < 0.0)] = Some(middle.normal);
    Some(middle)
}

/// As [`climb`], for one body and only over normals at right angles to the unit vector `axis`, of which `start` is one.
///
/// Beside a segment that is parallel to a flat place, both normals that a step tries may go back and forth across it.
/// One of some thousands of degenerate poses then ended 6e-7 of the size too low after 400 steps. So a step also tries
/// the normal half way between two slopes of opposite signs.
pub(super) fn climb_across(delta: DVec3, body: impl Supporting, axis: DVec3, start: DVec3) -> Peak<1> {
    let size = delta.length() + body.size();
    let slope_of = |peak: &Peak<1>| axis.cross(peak.normal).dot(delta - peak.points[0]);
    let mut peak = Peak::at(delta, &[body], start);
    let mut between = [None; 2];
    'steps: for _ in 0..MAX_STEPS {
        let (along, slope) = (axis.cross(peak.normal), slope_of(&peak));
        if slope.abs() <= GRADIENT_FLOOR * size {
            break;
        }
        between[usize::from(slope < 0.0)] = Some(peak.normal);
        let middle = halved(&mut between, |n| Peak::at(delta, &[body], n), slope_of);
        let h = body.hessian(peak.normal, peak.heights[0], (along, axis));
        let bend = peak.value + h.0;
        let newton = if bend > 0.0 { slope / bend } else { LONGEST_STEP.copysign(slope) };
        let mut step = newton.clamp(-LONGEST_STEP, LONGEST_STEP);
        loop {
            let moved = peak.points[0] + (along * h.0 + axis * h.1) * step;
            let across = |n: DVec3| (n - axis * axis.dot(n)).try_normalize();
            let mut best = Peak::at(delta, &[body], (peak.normal + along * step).normalize());
            if let Some(normal) = body.gauge(moved).and_then(|(_, normal)| across(normal)) {
                best = best.or(Peak::at(delta, &[body], normal));
            }
            best = middle.map_or(best, |middle| best.or(middle));
            if best.value > peak.value + GAIN * size {
                peak = best;
                break;
            }
            step *= SHORTEN;
            let is_visible = slope * step > VALUE_FLOOR * size;
            if !is_visible {
                break 'steps;
            }
        }
    }
    let (along, gap) = (axis.cross(peak.normal), slope_of(&peak));
    let h = body.hessian(peak.normal, peak.heights[0], (along, axis));
    let met = peak.points[0] + (along + axis * (h.1 / h.0)) * gap;
    if is_on(body, met) {
        peak.points[0] = met;
    }
    peak
}

/// Whether a point is on a body's surface; of no body whose gauge is not known.
fn is_on(body: impl Supporting, point: DVec3) -> bool {
    body.gauge(point).is_some_and(|(part, _)| (part - 1.0).abs() <= OFF)
}

/// A body's point with the normal of a peak: across from `p`, if that is on a flat place.
pub(super) fn point_across(p: DVec3, body: impl Supporting, peak: &Peak<1>) -> DVec3 {
    let across = p - peak.normal * peak.value;
    if is_on(body, across) { across } else { peak.points[0] }
}

impl<const N: usize> Peak<N> {
    /// The higher of two peaks, of equal ones this.
    fn or(self, other: Peak<N>) -> Peak<N> {
        if other.value > self.value { other } else { self }
    }

    /// The Hessians of the bodies' support functions.
    fn hessians(&self, bodies: &[impl Supporting; N], basis: Basis) -> [Hessian; N] {
        std::array::from_fn(|i| bodies[i].hessian(self.normal, self.heights[i], basis))
    }

    /// Moves the points across the normal to where they meet, if that is on the surfaces.
    fn meet(&mut self, delta: DVec3, bodies: &[impl Supporting; N]) {
        let (e1, e2) = self.normal.any_orthonormal_pair();
        let (g1, g2) = self.gradient(delta, (e1, e2));
        let hessians = self.hessians(bodies, (e1, e2));
        let (h11, h12, h22) = hessians.iter().fold((0.0, 0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
        let determinant = h11 * h22 - h12 * h12;
        let (s1, s2) = ((h22 * g1 - h12 * g2) / determinant, (h11 * g2 - h12 * g1) / determinant);
        let mut moves = hessians.map(|h| e1 * (h.0 * s1 + h.1 * s2) + e2 * (h.1 * s1 + h.2 * s2));
        // What rounding leaves is the first one's.
        let gap = e1 * g1 + e2 * g2;
        moves[0] = gap - moves[1..].iter().sum::<DVec3>();
        let is_near = |i: usize| {
            let (h, moved) = (hessians[i], moves[i]);
            // Of an ellipsoid by its curvature.
            let lower = 0.5 * (h.0 * s1 * s1 + 2.0 * h.1 * s1 * s2 + h.2 * s2 * s2);
            is_on(bodies[i], self.points[i] + moved) || !bodies[i].is_flat() && lower <= OFF * bodies[i].size()
        };
        let moves = if (0..N).all(is_near) { Some(moves) } else { self.shared(gap, bodies) };
        if let Some(moves) = moves {
            self.points.iter_mut().zip(moves).for_each(|(point, moved)| *point += moved);
        }
    }

    /// The moves by the shares of a gap that leave the points nearest to the surfaces, if they are on them.
    fn shared(&self, gap: DVec3, bodies: &[impl Supporting; N]) -> Option<[DVec3; N]> {
        let off = |i: usize, moved: DVec3| match bodies[i].gauge(self.points[i] + moved) {
            Some((part, _)) => (part - 1.0).abs(),
            None if moved == DVec3::ZERO => 0.0,
            None => f64::INFINITY,
        };
        let tried = SHARES.map(|share| {
            let moves: [DVec3; N] = std::array::from_fn(|i| gap * if i == 0 { 1.0 - share } else { share });
            (moves.iter().enumerate().map(|(i, moved)| off(i, *moved)).fold(0.0, f64::max), moves)
        });
        let (least, moves) = tried.into_iter().reduce(|best, next| if next.0 < best.0 { next } else { best })?;
        (N == 2 && least <= OFF).then_some(moves)
    }
}
