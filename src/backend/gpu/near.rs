//! The inputs of rows, and the first rows of a part of a step: those of near pairs.

use super::Device;
use super::candidates::Lists;
use super::row_set::RowSet;
use super::source::MidpointKernels;
use super::start::{Part, Stages};
use super::states::{Poses, Shapes};
use super::words;
use crate::gpu::{Buffer, Recorder};

/// What rows are made from.
#[derive(Clone, Copy)]
pub(super) struct RowInputs<'a> {
    pub stages: Stages<'a>,
    pub lists: &'a Lists,
    pub motions: &'a Buffer,
    /// Whether they are first rows made ahead of the step's start.
    pub ahead: bool,
    /// Where the bodies are and what they are there.
    pub poses: &'a Poses,
    pub shapes: &'a Shapes,
}

impl RowInputs<'_> {
    /// The part of the step that they are rows of.
    pub fn part(&self) -> Part {
        self.stages.start.part
    }

    /// How many pairs there are.
    pub fn pairs(&self) -> u64 {
        self.lists.pairs_count
    }

    /// Records that separations found in the middle become those with the lengths at the step's end.
    pub fn record_stretch(&self, record: &mut Recorder<'_>) {
        let Some(MidpointKernels { stretch: Some(stretch), .. }) = &self.stages.kernels.midpoint else { return };
        if self.part() != Part::FromMiddle {
            return;
        }
        let buffers = [
            ("pairs", &self.lists.pairs),
            ("orientations", &self.stages.here().orientations),
            ("shapes", &self.stages.here_shapes().shapes),
            ("grown", &self.stages.states.end_shapes().shapes),
            ("contacts", &self.lists.contacts),
        ];
        record.run(stretch, &words([self.pairs() as u32, 0, 0, 0]), &buffers, self.pairs());
    }
}

impl Device {
    /// The rows, and what they are made from: at the trial, or where first rows are made.
    pub(super) fn row_inputs(&mut self, at_trial: bool) -> (&mut RowSet, RowInputs<'_>) {
        let Device { gpu, setup, kernels, states, start, motions, first, narrow, rows, .. } = self;
        let stages = Stages { gpu, setup, kernels, states, start };
        let (poses, shapes) = match at_trial {
            true => (&states.trial, states.end_shapes()),
            false => (first.poses(stages), stages.here_shapes()),
        };
        let ahead = first.is_ahead(start.part) && !at_trial;
        let (lists, motions) = (&narrow.candidates.lists, &motions.motions);
        (rows, RowInputs { stages, lists, motions, ahead, poses, shapes })
    }
}
