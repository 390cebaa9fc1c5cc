//! Random draws for the shortest piece of a step, before it counts as one that cannot be taken: rows that push most are
//! tilted if it throws bodies, and cells that press each other are shaken if they find no way out.
//!
//! Rows see first order only. Cells in a wedge may have motions that keep all its contacts to first order, and open
//! them to second: two convex bodies that touch part by `s^2 / 2R` where they slide past each other by `s`. No row
//! shows such a way, so the bodies of the wedge are moved by a draw and parted, in no time and without growth. That
//! always has a solution, the start itself: the contacts that hold the wedge stay shut to first order, and the rest of
//! the draw is a motion of this kind.

use super::algorithm::{Attempt, Plan, attempt};
use super::retry::Taking;
use super::{Crowd, Fault, Piece, RetryBackend, Stepping};
use crate::dynamics::{Twist, Waiting, draw};
use crate::shape::Shape;
use crate::step::Overlap;
use glam::DVec3;

/// How far a draw moves a body and its ends, in halves of its thickness, one draw after the other.
const SIZES: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// Draws of each size.
const DRAWS_OF_A_SIZE: u32 = 4;

/// A draw that moves bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Shake {
    /// The sorted ids of the bodies that it moves.
    pub ids: Vec<u64>,
    /// Its number.
    pub draw: u32,
    /// How far it moves a body and its ends, in halves of its thickness.
    pub size: f64,
}

impl Shake {
    /// The velocity that moves a body by the draw in the time `dt`. `seed` is the scene's and `step` the last one.
    pub(crate) fn of_body(&self, shape: &Shape, id: u64, (seed, step): (u64, u64), dt: f64) -> Twist {
        if self.ids.binary_search(&id).is_err() {
            return Twist::default();
        }
        let [x, y, z, u, v, w] = draw::normals(seed ^ (u64::from(self.draw) << 40) ^ OF_SHAKES, id, step + 1);
        let length = self.size * 0.5 * shape.thickness() / dt;
        Twist {
            linear: length * DVec3::new(x, y, z).normalize_or_zero(),
            angular: length / shape.bounding_radius() * DVec3::new(u, v, w).normalize_or_zero(),
        }
    }
}

/// The largest number of random disturbances of a shortest piece that throws bodies. Of 200 random chambers one has
/// such a piece, and the disturbances resolve it.
const MOST_DISTURBANCES: u32 = 8;

/// Keeps these draws apart from those of tilts.
const OF_SHAKES: u64 = 1 << 63;

impl Taking<'_> {
    /// If the shortest piece threw bodies, takes it with the rows that push most tilted: a row of bodies that is about
    /// to buckle went to a side without a solution.
    pub(super) fn disturb(
        &mut self,
        again: &mut dyn RetryBackend,
        piece: Piece,
        failed: &Result<Attempt, Fault>,
    ) -> Result<Option<Overlap>, Fault> {
        if !failed.as_ref().is_ok_and(Attempt::throws) {
            return Ok(None);
        }
        for draw in 0..MOST_DISTURBANCES {
            again.prepare(piece, &self.waiting);
            let plan = Plan { disturbed: Some(draw), ..self.plan.clone() };
            match attempt(again, &plan, self.keep) {
                Ok(tried) if tried.holds(self.plan) => return self.accept(again, tried).map(Some),
                other => self.count_failure(&other),
            }
        }
        Ok(None)
    }

    /// Takes a piece after a draw has moved the bodies of the wedge of the last attempt.
    pub(super) fn shaken(&mut self, again: &mut dyn RetryBackend, piece: Piece) -> Result<Option<Overlap>, Fault> {
        let ids = again.crowded(Crowd::Wedged);
        let before = again.state()?.clone();
        for (number, size) in (0..).zip(SIZES) {
            for draw in number * DRAWS_OF_A_SIZE..(number + 1) * DRAWS_OF_A_SIZE {
                if self.shake(again, piece, Shake { ids: ids.clone(), draw, size })? {
                    match self.attempt(again, piece) {
                        Ok(mut tried) if tried.holds(self.plan) => {
                            tried.report.shaken = 1;
                            return self.accept(again, tried).map(Some);
                        }
                        failed => self.count_failure(&failed),
                    }
                }
                again.restore(&before)?;
            }
        }
        Ok(None)
    }

    /// Moves bodies by a draw where a piece begins, in no time. Returns whether they could be moved.
    fn shake(&mut self, again: &mut dyn RetryBackend, piece: Piece, shake: Shake) -> Result<bool, Fault> {
        let plan = Plan { stepping: Stepping::Euler, ..self.plan.clone() };
        again.part(true);
        again.shake(Some(shake));
        again.prepare(Piece { start: piece.span * piece.start, ..Piece::WHOLE }, &Waiting::All);
        let tried = attempt(again, &plan, self.keep);
        let moved = match &tried {
            Ok(tried) => tried.holds(&plan),
            Err(_) => false,
        };
        match tried {
            Ok(tried) if moved => {
                self.report.phases += again.accept()?;
                self.report.add_parting(&tried.report);
                self.report.add_cost(&tried.report);
            }
            failed => self.count_failure(&failed),
        }
        again.shake(None);
        again.part(false);
        Ok(moved)
    }
}
