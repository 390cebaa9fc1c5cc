//! De Saxce's correction `e = mu |s|` of the normal gaps, followed while the multipliers are iterated on.
//!
//! With `e` fixed the problem is convex; a solution of it with `e = mu |s|` obeys the exact law. Plain substitution
//! `e = mu |s|` cycles with period two where many contacts slide, and is slow where a contact slides alone: there
//! `mu |s|` rises by `r = mu^2 At / (An + mu^2 At)` as `e` does by one, with `An` and `At` the diagonal entries of `A`,
//! and a change by `1 / (1 - r) = 1 + mu^2 At / An` times what `e` is off is exact. So each contact has its own part of
//! the change: halved where the change turns its sign, else growing, up to that.

use super::cone::tangential;
use super::unit::Unit;

/// The smallest part of a change that is made, and how it grows.
pub(in crate::lcp) const SMALLEST: f64 = 0.05;
pub(in crate::lcp) const GROWTH: f64 = 1.2;

/// The corrections of all units.
#[derive(Clone, Debug, Default)]
pub(super) struct Follow {
    each: Vec<Correction>,
    begun: bool,
}

#[derive(Clone, Copy, Debug)]
struct Correction {
    offset: f64,
    /// The part of the change that is made next.
    part: f64,
    /// The last change wanted.
    last: f64,
}

impl Follow {
    /// None, of so many units.
    pub fn restart(&mut self, units: usize) {
        self.begun = false;
        self.each.clear();
        self.each.resize(units, Correction { offset: 0.0, part: 1.0, last: 0.0 });
    }

    /// The correction of a unit.
    #[inline]
    pub fn offset(&self, unit: usize) -> f64 {
        self.each[unit].offset
    }

    /// Lowers the corrections that are over those of the slips `g`, or without slips to zero. What they move by goes to
    /// the normal rows of `delta`.
    pub fn lower(&mut self, units: &[Unit], g: Option<&[f64]>, delta: &mut [f64]) {
        for (unit, own) in units.iter().zip(&mut self.each).filter(|(unit, _)| unit.mu > 0.0) {
            let lowered = g.map_or(0.0, |g| own.offset.min(unit.mu * tangential(unit.get(g))));
            delta[unit.rows().start] = lowered - own.offset;
            own.offset = lowered;
        }
    }

    /// Moves the corrections towards those of the gaps and slips `g`. What they move by goes to the normal rows of
    /// `delta`, whose other rows are zero.
    pub fn update(&mut self, units: &[Unit], g: &[f64], delta: &mut [f64]) {
        for (unit, own) in units.iter().zip(&mut self.each).filter(|(unit, _)| unit.mu > 0.0) {
            let change = unit.mu * tangential(unit.get(g)) - own.offset;
            // The first one takes the corrections of the start, and tells no direction.
            if self.begun {
                let turned = change * own.last < 0.0;
                own.part = if turned { (own.part / 2.0).max(SMALLEST) } else { (GROWTH * own.part).min(unit.most) };
                own.last = change;
            }
            let offset = (own.offset + own.part * change).max(0.0);
            delta[unit.rows().start] = offset - own.offset;
            own.offset = offset;
        }
        self.begun = true;
    }
}
