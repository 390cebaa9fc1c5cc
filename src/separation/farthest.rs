//! The normal of a custom shape at its point farthest from a point or a line: the largest `n . d + h(n)` over unit
//! normals, with `d` from the point to the body's centre; for a line, over normals at right angles to it.
//!
//! The distance from `p` to a point `y` is the largest `n . (y - p)`, and the support function is the maximum of `n .
//! y` over the body. So this is the search of `peak` with the opposite sign of the support function. It has several
//! local maxima, such as the body's ends, so the search starts from the best of fixed normals.
//!
//! Degenerate case: points at the same distance; the first in the order of starts counts.

use super::convex::{Posed, TIE, highest};
use super::direction::perpendicular;
use super::peak::{Peak, Supporting, climb_across};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The number of starts around a line.
pub(super) const ROUND: u32 = 32;

/// A body with the opposite sign of its support function.
#[derive(Clone, Copy)]
struct Outward(Posed);

impl Supporting for Outward {
    fn value_and_point(self, n: DVec3) -> (f64, DVec3) {
        let (value, point) = self.0.value_and_point(n);
        (-value, -point)
    }

    fn hessian(self, n: DVec3, value: f64, basis: (DVec3, DVec3)) -> (f64, f64, f64) {
        let (h11, h12, h22) = self.0.hessian(n, -value, basis);
        (-h11, -h12, -h22)
    }

    fn size(self) -> f64 {
        self.0.size()
    }

    fn aspect(self) -> f64 {
        self.0.aspect()
    }

    fn has_edges(self) -> bool {
        self.0.has_edges()
    }
}

/// The normal at the point farthest from `-delta`, and the distance of that point.
pub(super) fn from_point(delta: DVec3, body: Posed) -> (DVec3, f64) {
    let starts = delta.try_normalize().into_iter().chain(body.starts());
    highest(delta, &[Outward(body)], starts).map_or((DVec3::X, 0.0), |peak| (peak.normal, peak.value))
}

/// The normal, at right angles to the unit vector `axis`, at the point farthest from the line along it through
/// `-delta`.
pub(super) fn from_line(delta: DVec3, body: Posed, axis: DVec3) -> DVec3 {
    highest_across(delta, Outward(body), axis).normal
}

/// The highest peak over the normals at right angles to `axis`, the first among equals.
pub(super) fn highest_across(delta: DVec3, body: impl Supporting, axis: DVec3) -> Peak<1> {
    let first = perpendicular(axis);
    let second = axis.cross(first);
    let peak_from = |k: u32| {
        let turn = DVec2::from_angle(TAU * f64::from(k) / f64::from(ROUND));
        climb_across(delta, body, axis, first * turn.x + second * turn.y)
    };
    let tie = TIE * (delta.length() + body.size());
    (1..ROUND).map(peak_from).fold(peak_from(0), |best, peak| if peak.value > best.value + tie { peak } else { best })
}
