//! What of a step concerns periodic space: that a pair can meet at one image only.

use super::{Cpu, LEAST_BODIES_A_TASK};
use crate::step::Fault;
use rayon::prelude::*;

impl<const D: usize> Cpu<D> {
    /// Refuses bodies that reach, or move freely in this step, too far for the shortest period, so that other images
    /// than the nearest could come near, and bodies so far away that nearest images are made of rounding.
    pub(super) fn check_periods(&self) -> Result<(), Fault> {
        let periods = self.state.bodies.periods;
        let Some(period) = periods.shortest() else { return Ok(()) };
        let step = self.state.step + 1;
        let span =
            |body: usize| 2.0 * (self.start.shape[body].bounding_radius() + self.reach[body].either) + self.cutoff;
        // Not a number is refused.
        let fits = |body: usize| span(body) <= 0.5 * period;
        let bodies = 0..self.start.len();
        let parallel = || bodies.clone().into_par_iter().with_min_len(LEAST_BODIES_A_TASK);
        if let Some(body) = parallel().find_first(|body| !fits(*body)) {
            return Err(Fault::PeriodTooShort { step, body, span: span(body), period });
        }
        let far = |body: usize| periods.farthest(self.start.position[body]) * f64::EPSILON > self.overlap_tolerance;
        match parallel().find_first(|body| far(*body)) {
            Some(body) => Err(Fault::TooFar { step, body }),
            None => Ok(()),
        }
    }
}
