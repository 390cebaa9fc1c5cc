//! How a run is coming along, on standard error: a bar on a terminal, elsewhere a line every few seconds.

use super::output;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use relcp::run::Run;
use relcp::step::StepReport;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Time between lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Time between updates of the bar's text.
const TEXT_EVERY: Duration = Duration::from_millis(200);
/// Weight of the newest step in the running mean of the steps' wall time: it follows the last twenty or so.
const NEWEST: f64 = 0.05;

/// Shows a run's progress.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    shown: Instant,
    begun: Instant,
    cost: StepCost,
    /// How many legs there are that were looked at.
    legs: usize,
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
        let fastest = scene.growth.iter().map(|growth| growth.rate).fold(0.0, f64::max);
        let growth = fastest * scene.time.dt;
        let (now, legs) = (Instant::now(), run.totals().legs.len());
        Progress { bar, quiet, shown: now, begun: now, cost: StepCost::new(growth), legs }
    }

    /// Takes note of a step, and shows it where it is time to.
    pub(super) fn step(&mut self, run: &Run, report: &StepReport) {
        self.cost.add(self.begun.elapsed().as_secs_f64());
        self.begun = Instant::now();
        self.tell_legs(run);
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

    /// Says where another machine takes over for good, and what one should know of a device.
    fn tell_legs(&mut self, run: &Run) {
        let legs = &run.totals().legs;
        for leg in legs.iter().skip(std::mem::replace(&mut self.legs, legs.len())) {
            if self.quiet || (leg.message.is_none() && (leg.is_trial() || leg.is_return())) {
                continue;
            }
            match &self.bar {
                Some(bar) => bar.println(leg.to_string()),
                None => output::message(&leg.to_string()),
            }
        }
    }

    fn text(&self, run: &Run, report: &StepReport) -> String {
        let time = run.simulation().scene().time;
        let left = self.cost.left(time.steps().saturating_sub(report.step));
        let left = Duration::try_from_secs_f64(left).map_or("very long".into(), |d| HumanDuration(d).to_string());
        let removed = run.simulation().removed();
        let removed = if removed > 0 { format!(" ({removed} removed)") } else { String::new() };
        format!(
            "time {:.6} of {}, {} bodies{removed}, {} constraints, {} recursions, overlap up to {:.2e}, about {left} left",
            report.time,
            time.end,
            report.bodies,
            report.constraints,
            report.recursions,
            run.totals().max_overlap
        )
    }

    /// Takes the bar away.
    pub(super) fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// What the steps to come will take, judged by the last ones. The number of cells of a growing colony, and with it the
/// work of a step, grows by the factor `exp(growth)` a step.
struct StepCost {
    growth: f64,
    mean: f64,
    weight: f64,
}

impl StepCost {
    fn new(growth: f64) -> Self {
        StepCost { growth, mean: 0.0, weight: 0.0 }
    }

    fn add(&mut self, seconds: f64) {
        self.mean += NEWEST * (seconds - self.mean);
        self.weight += NEWEST * (1.0 - self.weight);
    }

    /// Seconds for so many more steps: the sum of `cost exp(growth i)` over them, as an integral.
    fn left(&self, steps: u64) -> f64 {
        let cost = if self.weight > 0.0 { self.mean / self.weight } else { 0.0 };
        let steps = steps as f64;
        if self.growth == 0.0 { cost * steps } else { cost * (self.growth * steps).exp_m1() / self.growth }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(growth: f64, costs: &[f64]) -> StepCost {
        let mut cost = StepCost::new(growth);
        costs.iter().for_each(|seconds| cost.add(*seconds));
        cost
    }

    #[test]
    fn equal_steps_are_taken_as_they_are_from_the_first_on() {
        assert!((after(0.0, &[0.5]).left(10) - 5.0).abs() < 1e-12);
        assert!((after(0.0, &[0.5; 7]).left(10) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_growing_colony_is_estimated_by_its_growth() {
        let (growth, steps) = (0.01, 300);
        let sum: f64 = (0..steps).map(|i| 0.5 * (growth * f64::from(i)).exp()).sum();
        let estimate = after(growth, &[0.5; 50]).left(steps as u64);
        assert!((estimate / sum - 1.0).abs() < 0.01, "{estimate} for {sum}");
    }
}
