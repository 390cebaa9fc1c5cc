//! The inputs from which rows are made.

use super::first::First;
use super::lists::Lists;
use super::motions::Motions;
use super::part::Part;
use super::start::Stages;
use super::states::{Poses, Shapes};
use crate::gpu::{Recorder, arguments, functions};

functions! {
    pub(super) Stretch = struct StretchArgs<'a> {
        lists: &'a Lists, here: &'a Poses, shapes: &'a Shapes, grown: &'a Shapes,
    }
}

arguments! {
    /// The inputs from which rows are made.
    #[derive(Clone, Copy)]
    pub(super) struct RowInputs<'a> {
        lists: &'a Lists,
        motions: &'a Motions,
        /// The poses and shapes of the bodies.
        poses: &'a Poses,
        shapes: &'a Shapes,
        stages: Stages<'a>,
        /// Whether these are first rows made at extrapolated positions.
        ahead: bool,
    }
}

impl<'a> RowInputs<'a> {
    /// The inputs at the trial, or in the state where first rows are made.
    pub fn of(stages: Stages<'a>, first: &First, lists: &'a Lists, motions: &'a Motions, at_trial: bool) -> Self {
        let (poses, shapes) = match at_trial {
            true => (&stages.states.trial, stages.states.end_shapes()),
            false => (first.poses(stages), stages.here_shapes()),
        };
        let ahead = first.is_ahead(stages.start.part) && !at_trial;
        RowInputs { lists, motions, poses, shapes, stages, ahead }
    }

    /// The part of the step to which the rows belong.
    pub fn part(&self) -> Part {
        self.stages.start.part
    }

    /// The number of pairs.
    pub fn pairs(&self) -> u64 {
        self.lists.pairs_count
    }

    /// Records the conversion of separations in the middle to the lengths at the step's end.
    pub fn record_stretch(&self, stretch: &Stretch, record: &mut Recorder<'_>) {
        if self.part() != Part::FromMiddle {
            return;
        }
        let (lists, here, shapes) = (self.lists, self.stages.here(), self.stages.here_shapes());
        let grown = self.stages.states.end_shapes();
        stretch.call(record, self.pairs(), StretchArgs { lists, here, shapes, grown });
    }
}
