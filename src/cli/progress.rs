//! The progress of a run on standard error: a bar on a terminal, elsewhere a line every few seconds.

use super::output;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use relcp::digits;
use relcp::run::Run;
use relcp::scene::Scene;
use relcp::step::StepReport;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Time between lines without a terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Time between updates of the bar's text.
const TEXT_EVERY: Duration = Duration::from_millis(200);
/// If the upper bound of the time left is at most this many times the lower one, one time is shown.
const CLOSE: f64 = 3.0;

/// Shows a run's progress.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    shown: Instant,
    begun: Instant,
    cost: StepCost,
}

impl Progress {
    pub(super) fn new(run: &Run, quiet: bool) -> Self {
        let scene = run.simulation().scene();
        let steps = scene.time.steps();
        // Lines of a log would cut through a bar.
        let logs = log::max_level() > log::LevelFilter::Off;
        let bar = (!quiet && !logs && std::io::stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("{bar:24} {percent:>3}%  {msg}");
            let bar = ProgressBar::new(steps).with_position(run.simulation().steps());
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        let now = Instant::now();
        Progress { bar, quiet, shown: now, begun: now, cost: StepCost::default() }
    }

    /// Records a step, and shows it when due.
    pub(super) fn step(&mut self, run: &Run, report: &StepReport) {
        self.cost.add(self.begun.elapsed().as_secs_f64());
        self.begun = Instant::now();
        let every = if self.bar.is_some() { TEXT_EVERY } else { LINE_EVERY };
        if self.quiet || self.shown.elapsed() < every {
            return;
        }
        self.shown = Instant::now();
        let text = self.text(run, report);
        match &self.bar {
            Some(bar) => {
                bar.set_position(report.step);
                bar.set_message(text);
            }
            None => output::message(&text),
        }
    }

    /// Leaves out the time since the last step, in which the run waited.
    pub(super) fn leave_out_wait(&mut self) {
        self.begun = Instant::now();
    }

    fn text(&self, run: &Run, report: &StepReport) -> String {
        let scene = run.simulation().scene();
        let time = scene.time;
        let left =
            in_words(self.cost.left(time.steps().saturating_sub(report.step), &Growing::of(scene, report.bodies)));
        let removed = run.simulation().removed();
        let removed = if removed > 0 { format!(" ({removed} removed)") } else { String::new() };
        format!(
            "time {} of {}, {}{removed}, {}, {}, overlap up to {}{left}",
            digits::time(report.time, time.dt),
            digits::time(time.end, time.dt),
            output::count(report.bodies, "body", "bodies"),
            output::count(report.constraints, "constraint", "constraints"),
            output::count(report.recursions as usize, "recursion", "recursions"),
            digits::beside(run.totals().max_overlap, scene.contact.overlap_tolerance)
        )
    }

    /// Removes the bar.
    pub(super) fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// The time left, by its bounds in seconds.
fn in_words([least, most]: [f64; 2]) -> String {
    let of = |seconds: f64| Duration::try_from_secs_f64(seconds).map(|left| HumanDuration(left).to_string());
    let (seconds, how) = if most <= CLOSE * least { ((least * most).sqrt(), "about") } else { (least, "more than") };
    of(seconds).map_or_else(|_| String::new(), |left| format!(", {how} {left} left"))
}

/// The upper bound on the growth of the number of bodies, and so of the work per step.
struct Growing {
    /// It grows by the factor `exp(rate)` per step.
    rate: f64,
    /// Up to this factor.
    most: f64,
    /// Whether nothing slows the cells, so that the run ends when that factor is reached.
    is_free: bool,
}

impl Growing {
    fn of(scene: &Scene, bodies: usize) -> Growing {
        let fastest = scene.growth.iter().map(|growth| growth.rate).fold(0.0, f64::max);
        let population = scene.stop().and_then(|stop| stop.population);
        let most = population.map_or(f64::INFINITY, |most| (most as f64 / bodies.max(1) as f64).max(1.0));
        let is_free = scene.walls.is_empty() && scene.removal.is_empty() && scene.periodic.is_none();
        Growing { rate: fastest * scene.time.dt, most, is_free }
    }
}

/// Estimates the cost of the remaining steps from those since at most half of the steps: a single step that waited for
/// the disk soon counts little.
#[derive(Default)]
struct StepCost {
    steps: u64,
    seconds: f64,
    /// Steps and seconds at two earlier moments, each at half the steps of what follows it.
    since: [(u64, f64); 2],
}

impl StepCost {
    fn add(&mut self, seconds: f64) {
        self.steps += 1;
        self.seconds += seconds;
        if self.steps >= 2 * self.since[1].0.max(1) {
            self.since = [self.since[1], (self.steps, self.seconds)];
        }
    }

    /// Lower and upper bound, in seconds, for `steps` more steps: at the present cost, and at a cost that grows with
    /// the bodies.
    fn left(&self, steps: u64, growing: &Growing) -> [f64; 2] {
        let (before, seconds) = self.since[0];
        let cost = (self.seconds - seconds) / (self.steps - before).max(1) as f64;
        let (steps, rate) = (steps as f64, growing.rate);
        if rate == 0.0 {
            return [cost * steps; 2];
        }
        // The sum of `cost exp(rate i)` over the steps, as an integral, plus the steps after growth has ended.
        let growth_ends = (growing.most.ln() / rate).min(steps);
        let grown = cost * (rate * growth_ends).exp_m1() / rate;
        if growing.is_free {
            return [cost * growth_ends, grown];
        }
        [cost * growth_ends, grown + cost * (rate * growth_ends).exp() * (steps - growth_ends)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONSTANT: Growing = Growing { rate: 0.0, most: f64::INFINITY, is_free: true };

    fn after(costs: impl IntoIterator<Item = f64>) -> StepCost {
        let mut cost = StepCost::default();
        costs.into_iter().for_each(|seconds| cost.add(seconds));
        cost
    }

    #[test]
    fn equal_steps_are_taken_as_they_are_from_the_first_on() {
        for steps in 1..40 {
            let [least, most] = after(vec![0.5; steps]).left(10, &CONSTANT);
            assert!((least - 5.0).abs() < 1e-12 && least == most);
        }
    }

    #[test]
    fn the_time_left_of_a_run_of_seconds_is_not_hours_where_one_step_waited_for_the_disk() {
        let waited = after((0..1_000).map(|step| if step == 300 { 4.0 } else { 1e-3 }));
        let [_, most] = waited.left(10_000, &CONSTANT);
        assert!(most < 90.0, "{most}");
        assert_eq!(in_words([11.0; 2]), ", about 11 seconds left");
    }

    #[test]
    fn the_time_left_of_a_growing_colony_is_bounded_on_both_sides() {
        let (rate, steps) = (0.01, 300);
        let sum: f64 = (0..steps).map(|i| 0.5 * (rate * f64::from(i)).exp()).sum();
        let free = |most| Growing { rate, most, is_free: true };
        let [least, most] = after([0.5; 50]).left(steps as u64, &free(f64::INFINITY));
        assert!((most / sum - 1.0).abs() < 0.01 && (least - 150.0).abs() < 1e-9, "{least} {most} for {sum}");
        assert_eq!(in_words([150.0, 950.0]), ", more than 3 minutes left");
        // It ends at twice the cells, however late its `time.end` is.
        let [least, most] = after([0.5; 50]).left(1_000_000, &free(2.0));
        assert!(least > 30.0 && most < 60.0, "{least} {most}");
        let [_, most] = after([0.5; 50]).left(1_000, &Growing { rate, most: 2.0, is_free: false });
        assert!((900.0..1_000.0).contains(&most), "{most}");
    }
}
