//! Which steps are recorded: a function of the step's index alone, so that a resumed run records the same steps.

use crate::record::Parent;
use crate::scene::Scene;
use crate::simulation::Simulation;

/// A time this far below a multiple of the interval counts as the multiple, relative to the interval: far above the
/// rounding of a time divided by an interval, far below any step.
const ROUNDING: f64 = 1e-9;

/// Which steps are recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Schedule {
    /// The step after which the run began: 0, or that of another run's state.
    first: u64,
    /// The time since which the interval is counted.
    start: f64,
    steps: u64,
    stride: u64,
    /// Steps between states; may be less than one.
    interval: f64,
    /// Steps from that time to step 0. After a change of the step size it is not 0.
    offset: f64,
}

impl Schedule {
    /// That of a run, which began with its scene's own bodies or with a state of another run.
    pub(super) fn of(simulation: &Simulation, parent: Option<&Parent>) -> Self {
        let start = simulation.whole_scene().time.start;
        Schedule::new(simulation.scene(), parent.map_or(0, |parent| parent.step), start)
    }

    fn new(scene: &Scene, first: u64, start: f64) -> Self {
        let time = scene.time;
        // A run without duration has no steps.
        let interval = scene.output_every().map_or(1.0, |every| every / time.dt);
        let offset = (time.start - start) / time.dt;
        Schedule { first, start, steps: time.steps(), stride: scene.output.step_stride.max(1), interval, offset }
    }

    /// The rest of the schedule after a change of the scene.
    pub(super) fn changed(self, scene: &Scene) -> Self {
        Schedule::new(scene, self.first, self.start)
    }

    /// Whether the state after this step is recorded: the start, the end, and the first step at or after each multiple
    /// of the interval.
    pub(super) fn state_due(&self, step: u64) -> bool {
        let passed = |step: u64| ((step as f64 + self.offset) / self.interval + ROUNDING).floor();
        step == self.first || step == self.steps || passed(step) > passed(step - 1)
    }

    /// Whether this step has a row in `steps.csv`: every stride-th, and the last.
    pub(super) fn row_due(&self, step: u64) -> bool {
        step > self.first && (step.is_multiple_of(self.stride) || step == self.steps)
    }

    /// The last row after `step` steps.
    pub(super) fn last_row(&self, step: u64) -> Option<u64> {
        let last = if self.row_due(step) { step } else { step - step % self.stride };
        (last > self.first).then_some(last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Schedule = Schedule { first: 0, start: 0.0, steps: 0, stride: 1, interval: 1.0, offset: 0.0 };

    fn due(schedule: Schedule) -> Vec<u64> {
        (0..=schedule.steps).filter(|&step| schedule.state_due(step)).collect()
    }

    #[test]
    fn states_fall_on_multiples_and_on_both_ends() {
        assert_eq!(due(Schedule { steps: 10, interval: 4.0, ..PLAIN }), [0, 4, 8, 10]);
        // 0.3 / 0.1 is under 3 in floating point.
        assert_eq!(due(Schedule { steps: 7, interval: 0.3 / 0.1, ..PLAIN }), [0, 3, 6, 7]);
        assert_eq!(due(Schedule { steps: 6, interval: 2.5, ..PLAIN }), [0, 3, 5, 6]);
        assert_eq!(due(Schedule { steps: 3, interval: 0.2, ..PLAIN }), [0, 1, 2, 3]);
        assert_eq!(due(Schedule { steps: 0, interval: 0.0, ..PLAIN }), [0]);
    }

    #[test]
    fn states_fall_on_multiples_where_other_steps_went_before() {
        // From time 1 on, step 10, in steps of 0.04, every 0.25.
        let after = Schedule { first: 10, steps: 35, interval: 6.25, offset: 0.6 / 0.04, ..PLAIN };
        assert_eq!((10..=35).filter(|&step| after.state_due(step)).collect::<Vec<_>>(), [10, 17, 23, 29, 35]);
    }

    #[test]
    fn rows_fall_on_the_stride_and_the_last_step() {
        let schedule = Schedule { steps: 10, stride: 4, interval: 1.0, ..PLAIN };
        assert_eq!((0..=10).filter(|&s| schedule.row_due(s)).collect::<Vec<_>>(), [4, 8, 10]);
        let last: Vec<_> = [0, 3, 4, 9, 10].map(|s| schedule.last_row(s)).into();
        assert_eq!(last, [None, None, Some(4), Some(8), Some(10)]);
        let last: Vec<_> = [5, 7, 8, 10].map(|s| Schedule { first: 5, ..schedule }.last_row(s)).into();
        assert_eq!(last, [None, None, Some(8), Some(10)]);
    }
}
