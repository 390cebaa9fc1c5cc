//! The parts of a step that are computed.

use super::Setup;

/// The part of a step that is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// The whole step, from its start.
    Whole,
    /// Its first half.
    FirstHalf,
    /// The whole step, with the forces, mobilities and first rows of its middle.
    FromMiddle,
}

impl Setup {
    /// The first part of a step.
    pub(super) fn first_part(&self) -> Part {
        if self.midpoint { Part::FirstHalf } else { Part::Whole }
    }

    /// The length of a part.
    pub(super) fn length_of(&self, part: Part) -> f64 {
        if part == Part::FirstHalf { 0.5 * self.dt } else { self.dt }
    }
}
