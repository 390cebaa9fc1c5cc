//! Counts of the operations of a device by stage.

use super::Counters;

/// The name of the stage for work before the first named stage.
pub(super) const UNNAMED: &str = "other";

/// Counters by stage, in the order in which the stages were first named. There are at most some twenty stages, so a
/// linear search suffices.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    stages: Vec<(&'static str, Counters)>,
    /// Bytes written for the next submission.
    for_next: u64,
}

impl Tally {
    /// The counters of a stage.
    pub fn of(&mut self, stage: &'static str) -> &mut Counters {
        let at = self.stages.iter().position(|(name, _)| *name == stage).unwrap_or_else(|| {
            self.stages.push((stage, Counters::default()));
            self.stages.len() - 1
        });
        &mut self.stages[at].1
    }

    /// Counts bytes that the host wrote. They belong to the next submission.
    pub fn write(&mut self, bytes: u64) {
        self.for_next += bytes;
    }

    /// Adds recorded work whose last stage was `stage`. Bytes written before belong to its first stage.
    pub fn add(&mut self, recorded: &mut Tally, stage: &'static str) {
        let first = recorded.stages.first().map_or(stage, |(first, _)| first);
        self.of(first).bytes_written += std::mem::take(&mut self.for_next);
        for (name, counters) in recorded.stages.drain(..) {
            *self.of(name) += counters;
        }
    }

    /// Stages and counters; bytes without a submission yet belong to `other`.
    pub fn stages(&self) -> Vec<(&'static str, Counters)> {
        let mut all = self.clone();
        let written = std::mem::take(&mut all.for_next);
        if written > 0 {
            all.of(UNNAMED).bytes_written += written;
        }
        all.stages
    }

    /// The sum of the counters of all stages.
    pub fn total(&self) -> Counters {
        let mut total = Counters { bytes_written: self.for_next, ..Counters::default() };
        self.stages.iter().for_each(|(_, counters)| total += *counters);
        total
    }
}
