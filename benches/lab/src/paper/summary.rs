//! A summary of the steps of a run, over all steps and over windows of steps.

use crate::StudyError;
use crate::machine::{Begun, Took};
use relcp::scene::{Method, Scene};
use relcp::simulation::Simulation;
use relcp::step::{State, StepReport, contacts};
use serde::Serialize;

/// The name of a contact method in tables, the paper's.
pub fn method_name(method: Method) -> String {
    match method {
        Method::Snsd => "LCP-SNSD".into(),
        Method::Multisphere { count } => format!("LCP-MS {count}"),
        _ => "ReLCP".into(),
    }
}

/// Some steps of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Window {
    /// The contact method.
    pub method: String,
    /// The step size.
    pub dt: f64,
    /// The last of the steps.
    pub step: u64,
    /// Time after it.
    pub time: f64,
    /// Bodies after it.
    pub bodies: usize,
    /// How many steps they are.
    pub steps: u64,
    /// Rows of the last LCP of a step, on average.
    pub constraints: f64,
    /// Milliseconds of a step, on average, as [`RunSummary::milliseconds`].
    pub milliseconds: f64,
    /// Recursions of a step, on average.
    pub recursions: f64,
    /// Applications of `A` of a step, on average.
    pub products: f64,
    /// Their largest overlap of smooth surfaces, a length.
    pub max_overlap: f64,
    /// Their largest overlap of sub-spheres.
    pub proxy_overlap: Option<f64>,
}

/// The summary of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSummary {
    /// The contact method.
    pub method: String,
    /// Sub-spheres of a body, where its rows are made from these.
    pub spheres: Option<u32>,
    /// The step size.
    pub dt: f64,
    /// Bodies at the end.
    pub bodies: usize,
    /// Steps taken.
    pub steps: u64,
    /// Time at the end.
    pub time: f64,
    /// Milliseconds of all steps: the processor's, of all threads; the clock's where the system does not tell them.
    pub milliseconds: f64,
    /// The clock's milliseconds of all steps.
    pub wall_milliseconds: f64,
    /// Rows of the last LCP of the last step.
    pub last_constraints: usize,
    /// The same of a step, on average.
    pub constraints: f64,
    /// Recursions.
    pub recursions: u64,
    /// Applications of `A`.
    pub products: u64,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
    /// The overlap tolerance.
    pub overlap_tolerance: f64,
    /// The largest overlap of smooth surfaces after any step, a length.
    pub max_overlap: f64,
    /// The same at the end, computed afresh from the bodies alone.
    pub last_overlap: f64,
    /// The largest overlap of sub-spheres after any step.
    pub proxy_overlap: Option<f64>,
    /// Steps that left more than the tolerance between smooth surfaces.
    pub steps_over: u64,
    /// Its windows over time.
    #[serde(skip)]
    pub windows: Vec<Window>,
}

impl RunSummary {
    fn new(scene: &Scene) -> Self {
        let method = scene.contact.method;
        let spheres = if let Method::Multisphere { count } = method { Some(count) } else { None };
        RunSummary {
            method: method_name(method),
            spheres,
            dt: scene.time.dt,
            bodies: 0,
            steps: 0,
            time: scene.time.start,
            milliseconds: 0.0,
            wall_milliseconds: 0.0,
            last_constraints: 0,
            constraints: 0.0,
            recursions: 0,
            products: 0,
            unconverged: 0,
            overlap_tolerance: scene.contact.overlap_tolerance,
            max_overlap: 0.0,
            last_overlap: 0.0,
            proxy_overlap: None,
            steps_over: 0,
            windows: Vec::new(),
        }
    }

    /// Whether it is a run of ReLCP.
    pub fn is_relcp(&self) -> bool {
        self.method == method_name(Method::Relcp)
    }

    /// Whether ReLCP did not hold its overlap tolerance, or a solve of it its own. What other methods miss is what a
    /// study shows.
    pub fn missed(&self) -> bool {
        let over = self.max_overlap.max(self.last_overlap) > self.overlap_tolerance;
        self.is_relcp() && (self.unconverged > 0 || over)
    }

    /// Milliseconds of a step, as [`RunSummary::milliseconds`].
    pub fn step_milliseconds(&self) -> f64 {
        self.milliseconds / self.steps.max(1) as f64
    }

    /// The windows of this run and those of another that end at the same step, as far as both go.
    pub fn beside<'a>(&'a self, other: &'a RunSummary) -> impl Iterator<Item = (&'a Window, &'a Window)> {
        let same = self.dt == other.dt;
        self.windows.iter().zip(&other.windows).filter(move |(a, b)| same && a.step == b.step)
    }

    fn count(&mut self, report: &StepReport, took: &Took) {
        self.steps += 1;
        self.time = report.time;
        self.bodies = report.bodies;
        self.milliseconds += 1e3 * took.processor.as_secs_f64();
        self.wall_milliseconds += 1e3 * took.wall.as_secs_f64();
        self.last_constraints = report.constraints;
        self.constraints += (report.constraints as f64 - self.constraints) / self.steps as f64;
        self.recursions += u64::from(report.recursions);
        self.products += report.products;
        self.unconverged += u64::from(report.unconverged);
        self.max_overlap = self.max_overlap.max(report.max_overlap);
        self.proxy_overlap = largest(self.proxy_overlap, report.proxy_overlap);
        self.steps_over += u64::from(!report.within(self.overlap_tolerance));
    }

    fn begin_window(&mut self) {
        self.windows.push(Window {
            method: self.method.clone(),
            dt: self.dt,
            step: 0,
            time: 0.0,
            bodies: 0,
            steps: 0,
            constraints: 0.0,
            milliseconds: 0.0,
            recursions: 0.0,
            products: 0.0,
            max_overlap: 0.0,
            proxy_overlap: None,
        });
    }
}

impl Window {
    fn count(&mut self, report: &StepReport, took: &Took) {
        self.step = report.step;
        self.time = report.time;
        self.bodies = report.bodies;
        self.steps += 1;
        let steps = self.steps as f64;
        let averages = [
            (&mut self.constraints, report.constraints as f64),
            (&mut self.milliseconds, 1e3 * took.processor.as_secs_f64()),
            (&mut self.recursions, f64::from(report.recursions)),
            (&mut self.products, report.products as f64),
        ];
        for (average, value) in averages {
            *average += (value - *average) / steps;
        }
        self.max_overlap = self.max_overlap.max(report.max_overlap);
        self.proxy_overlap = largest(self.proxy_overlap, report.proxy_overlap);
    }
}

fn largest(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

/// Makes a run from the scene's bodies, or from a state of another run of the same bodies, in windows of `width` steps.
///
/// # Errors
/// [`StudyError`] where a step cannot be taken.
pub fn follow(scene: Scene, from: Option<State>, width: u64) -> Result<(RunSummary, Simulation), StudyError> {
    follow_with(scene, from, width, |_, _| Ok(()))
}

/// As [`follow`], and lets `observe` see the simulation after every step, with the number of the window that the step
/// is in.
///
/// # Errors
/// As [`follow`], and those of `observe`.
pub fn follow_with(
    scene: Scene,
    from: Option<State>,
    width: u64,
    mut observe: impl FnMut(&Simulation, usize) -> Result<(), StudyError>,
) -> Result<(RunSummary, Simulation), StudyError> {
    let mut summary = RunSummary::new(&scene);
    let mut simulation = match from {
        Some(state) => Simulation::builder(scene).resume(state).build()?,
        None => Simulation::new(scene)?,
    };
    summary.bodies = simulation.bodies();
    while !simulation.done() {
        let begun = Begun::now();
        let report = simulation.step()?;
        let took = begun.elapsed();
        if summary.steps.is_multiple_of(width.max(1)) {
            summary.begin_window();
        }
        summary.count(&report, &took);
        if let Some(window) = summary.windows.last_mut() {
            window.count(&report, &took);
        }
        observe(&simulation, summary.windows.len() - 1)?;
    }
    let overlaps = contacts(&simulation.state()?.bodies, 0.0);
    summary.last_overlap = overlaps.iter().map(|contact| -contact.separation).fold(0.0, f64::max);
    Ok((summary, simulation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_summed_up_in_windows() {
        let mut scene = Scene::load("two-ellipsoids", ["time.end=8", "time.dt=0.1"]).unwrap();
        scene.contact.method = Method::Multisphere { count: 7 };
        let (summary, simulation) = follow(scene, None, 30).unwrap();
        let steps: Vec<u64> = summary.windows.iter().map(|window| window.steps).collect();
        assert_eq!((steps, summary.steps, simulation.steps()), (vec![30, 30, 20], 80, 80));
        let sum = |of: fn(&Window) -> f64| summary.windows.iter().map(|w| of(w) * w.steps as f64).sum::<f64>();
        assert!((sum(|w| w.products) / summary.products as f64 - 1.0).abs() < 1e-12);
        assert!((sum(|w| w.constraints) / (80.0 * summary.constraints) - 1.0).abs() < 1e-12);
        assert!((sum(|w| w.milliseconds) / summary.milliseconds - 1.0).abs() < 1e-9);
        let worst = summary.windows.iter().map(|w| w.max_overlap).fold(0.0, f64::max);
        assert_eq!((summary.max_overlap, summary.spheres, &*summary.method), (worst, Some(7), "LCP-MS 7"));
        assert!(summary.proxy_overlap.is_some_and(|overlap| overlap < 1e-5) && !summary.missed());
        // The last step's own figure of the smooth surfaces, computed anew.
        let last = summary.windows[2].max_overlap;
        assert!(summary.last_overlap <= last && summary.steps_over > 0, "{} {last}", summary.last_overlap);
    }

    #[test]
    fn a_run_goes_on_from_the_state_of_another_method() {
        let load = |end: &str| Scene::load("two-ellipsoids", [end, "time.dt=0.1"]).unwrap();
        let (_, relcp) = follow(load("time.end=8"), None, 80).unwrap();
        let mut scene = load("time.end=8.5");
        scene.contact.method = Method::Multisphere { count: 5 };
        let state = State { warm: Vec::new(), ..relcp.state().unwrap().clone() };
        let (summary, _) = follow(scene, Some(state), 2).unwrap();
        assert_eq!((summary.steps, summary.windows.len(), summary.windows[2].step), (5, 3, 85));
    }
}
