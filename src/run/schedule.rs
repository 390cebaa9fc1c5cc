//! Which steps are recorded: a function of the step's index alone, so that a resumed run records the same steps.

use crate::scene::Scene;

/// A time this far below a multiple of the interval counts as the multiple, relative to the interval: far above the
/// rounding of a time divided by an interval, far below any step.
const ROUNDING: f64 = 1e-9;

/// Which steps are recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Schedule {
    steps: u64,
    stride: u64,
    /// Steps between states; may be less than one.
    interval: f64,
}

impl Schedule {
    pub(super) fn new(scene: &Scene) -> Self {
        let steps = scene.time.steps();
        // A run without duration has no steps.
        let interval = scene.output_every().map_or(1.0, |every| every / scene.time.dt);
        Schedule { steps, stride: scene.output.step_stride.max(1), interval }
    }

    /// Whether the state after this step is recorded: the start, the end, and the first step at or after each multiple
    /// of the interval.
    pub(super) fn state_due(&self, step: u64) -> bool {
        let passed = |step: u64| (step as f64 / self.interval + ROUNDING).floor();
        step == 0 || step == self.steps || passed(step) > passed(step - 1)
    }

    /// Whether this step has a row in `steps.csv`: every stride-th, and the last.
    pub(super) fn row_due(&self, step: u64) -> bool {
        step > 0 && (step.is_multiple_of(self.stride) || step == self.steps)
    }

    /// The last row after `step` steps.
    pub(super) fn last_row(&self, step: u64) -> Option<u64> {
        let last = if self.row_due(step) { step } else { step - step % self.stride };
        (last > 0).then_some(last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn due(schedule: Schedule) -> Vec<u64> {
        (0..=schedule.steps).filter(|&step| schedule.state_due(step)).collect()
    }

    #[test]
    fn states_fall_on_multiples_and_on_both_ends() {
        assert_eq!(due(Schedule { steps: 10, stride: 1, interval: 4.0 }), [0, 4, 8, 10]);
        // 0.3 / 0.1 is under 3 in floating point.
        assert_eq!(due(Schedule { steps: 7, stride: 1, interval: 0.3 / 0.1 }), [0, 3, 6, 7]);
        assert_eq!(due(Schedule { steps: 6, stride: 1, interval: 2.5 }), [0, 3, 5, 6]);
        assert_eq!(due(Schedule { steps: 3, stride: 1, interval: 0.2 }), [0, 1, 2, 3]);
        assert_eq!(due(Schedule { steps: 0, stride: 1, interval: 0.0 }), [0]);
    }

    #[test]
    fn rows_fall_on_the_stride_and_the_last_step() {
        let schedule = Schedule { steps: 10, stride: 4, interval: 1.0 };
        assert_eq!((0..=10).filter(|&s| schedule.row_due(s)).collect::<Vec<_>>(), [4, 8, 10]);
        let last: Vec<_> = [0, 3, 4, 9, 10].map(|s| schedule.last_row(s)).into();
        assert_eq!(last, [None, None, Some(4), Some(8), Some(10)]);
    }
}
