//! Uneven divisions: both daughters of a cell share their length anew.
//!
//! A division gives each daughter half of her mother's length. Where a rule gives them other lengths, the place where
//! the cell was cut moves along both: each keeps her outer tip and her axis, and her centre moves by half of what she
//! gains. Under the inertial law it moves with the velocity of the body that it is a point of.

use super::apply::Applied;
use super::limits::Limits;
use crate::bodies::Bodies;
use crate::digits::exact;
use glam::DVec3;

/// The daughters' lengths add up to what they have up to this part: a user computes the second as what is left.
const SUM_TOLERANCE: f64 = 1e-9;

/// New lengths of two daughters of one cell, the one at her lower end first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    pub daughters: [usize; 2],
    pub lengths: [f64; 2],
}

impl Applied {
    /// Shares the length of two daughters. The error names the daughter.
    pub(super) fn share(&mut self, limits: &Limits, share: &Share) -> Result<(), (usize, String)> {
        let Share { daughters: [lower, upper], lengths } = *share;
        let bodies = &mut self.state.bodies;
        let before = [lower, upper].map(|i| bodies.shape[i].major_axis());
        let mut shapes = [bodies.shape[lower], bodies.shape[upper]];
        for ((body, length), shape) in [lower, upper].into_iter().zip(lengths).zip(&mut shapes) {
            *shape = limits.lengthened(bodies, body, length).map_err(|why| (body, why))?;
        }
        let (whole, sum) = (before[0] + before[1], lengths[0] + lengths[1]);
        if (sum - whole).abs() > SUM_TOLERANCE * whole {
            let (sum, whole) = (exact(sum), exact(whole));
            return Err((lower, format!("the lengths of two daughters add up to {whole}, which they have, not {sum}")));
        }
        let gained = lengths[0] - before[0];
        for ((body, shape), (now, was)) in [lower, upper].into_iter().zip(shapes).zip(lengths.into_iter().zip(before)) {
            let line = &mut bodies.lineage[body];
            line.birth_length = line.birth_length.map(|birth| birth * now / was);
            bodies.shape[body] = shape;
            shift(bodies, body, 0.5 * gained, limits);
        }
        [lower, upper].into_iter().for_each(|body| self.lengthened(body));
        Ok(())
    }
}

/// Moves a body's centre along its axis.
fn shift(bodies: &mut Bodies, body: usize, by: f64, limits: &Limits) {
    let mut shift = by * (bodies.orientation[body] * DVec3::Z);
    if limits.plane.is_some() {
        shift.z = 0.0; // the axis lies in the plane up to rounding, the centres exactly
    }
    bodies.position[body] += shift;
    if limits.model.dynamics.has_inertia() {
        let turning = bodies.angular_velocity[body].cross(shift);
        bodies.velocity[body] += turning;
    }
}
