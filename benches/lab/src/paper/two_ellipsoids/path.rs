//! One run, and the path that it takes.

use super::l2;
use crate::StudyError;
use glam::DVec3;
use relcp::scene::{Method, Rows, Scene, Stepping};
use relcp::separation::Placed;
use relcp::simulation::Simulation;
use serde::Serialize;
use std::f64::consts::PI;
use std::time::{Duration, Instant};

/// Time between samples of a path; runs with longer steps are sampled at each. Every step that is measured divides it
/// or is a multiple of it.
const INTERVAL: f64 = 0.1;

/// A short run is repeated until this total time or this number of repeats. The shortest time counts.
const REPEAT_WITHIN: Duration = Duration::from_millis(300);
const REPEATS: usize = 5;

/// How a run is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// ReLCP by the paper's step.
    Euler,
    /// ReLCP by the midpoint step.
    Midpoint,
    /// Rows of sub-spheres, by the paper's step.
    Multisphere,
}

impl Scheme {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Scheme::Euler => "ReLCP",
            Scheme::Midpoint => "ReLCP, midpoint",
            Scheme::Multisphere => "LCP-MS",
        }
    }

    /// Whether its runs differ by their steps.
    pub(super) fn has_an_order(self) -> bool {
        self != Scheme::Multisphere
    }
}

/// To which side of the lower body the upper one's centre is, by half a unit each. Both long axes point to the upper
/// right. The paper says that "centers are offset by a unit distance along x", not to which side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// To the left: the bodies slip past each other.
    Left,
    /// To the right, as in the built-in scene: they turn until they lie flat on each other, and part slowly from there.
    Right,
}

impl Side {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Side::Left => "left",
            Side::Right => "right",
        }
    }
}

/// A run that is to be made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Case {
    /// How it is stepped.
    pub scheme: Scheme,
    /// Its step.
    pub dt: f64,
    /// Sub-spheres of a body.
    pub spheres: Option<u32>,
    /// To which side the upper body is.
    pub side: Side,
}

impl Case {
    /// Its name.
    pub fn name(&self) -> String {
        let side = self.side.name();
        match self.spheres {
            Some(count) => format!("{side}: {}, {count} spheres", self.scheme.name()),
            None => format!("{side}: {}, dt {}", self.scheme.name(), self.dt),
        }
    }

    /// The scene.
    ///
    /// # Errors
    /// [`StudyError::Scene`], which the tests rule out.
    pub fn scene(&self) -> Result<Scene, StudyError> {
        let mut scene = Scene::load("two-ellipsoids", &[format!("time.dt={}", self.dt)])?;
        scene.contact.rows = Rows::Paper;
        if self.side == Side::Left {
            for body in &mut scene.bodies {
                body.position[0] *= -1.0;
            }
        }
        if self.scheme == Scheme::Midpoint {
            scene.time.stepping = Stepping::Midpoint;
        }
        if let Some(count) = self.spheres {
            scene.contact.method = Method::Multisphere { count };
        }
        Ok(scene)
    }
}

/// The upper body's path, by samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Time between samples.
    pub interval: f64,
    /// Its x, y and the angle of its long axis in radians, followed through turns of more than a half.
    pub samples: [Vec<f64>; 3],
}

impl Path {
    pub(super) fn new(interval: f64) -> Self {
        Path { interval, samples: Default::default() }
    }

    pub(super) fn push(&mut self, body: &Placed) {
        let axis = body.orientation * DVec3::Z;
        let angle = axis.y.atan2(axis.x);
        // An axis has no head: of its angles the one that is nearest to the last, at first the one in the right half
        // plane.
        let near = self.samples[2].last().copied().unwrap_or(0.0);
        let angle = angle - PI * ((angle - near) / PI).round();
        for (samples, value) in self.samples.iter_mut().zip([body.position.x, body.position.y, angle]) {
            samples.push(value);
        }
    }

    /// This path at every `interval` only, a multiple of its own.
    pub(super) fn every(&self, interval: f64) -> Path {
        let stride = ((interval / self.interval).round() as usize).max(1);
        let samples = self.samples.each_ref().map(|samples| samples.iter().copied().step_by(stride).collect());
        Path { interval: self.interval * stride as f64, samples }
    }

    /// Errors of x, y and angle against a path with samples at least as close.
    pub fn errors(&self, reference: &Path) -> [f64; 3] {
        let common = self.interval.max(reference.interval);
        let (own, other) = (self.every(common), reference.every(common));
        [0, 1, 2].map(|i| l2(&own.samples[i], &other.samples[i], common))
    }

    /// The norms of x, y and angle themselves.
    pub fn norms(&self) -> [f64; 3] {
        self.samples.each_ref().map(|samples| l2(samples, &vec![0.0; samples.len()], self.interval))
    }
}

/// A run that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// What was run.
    pub case: Case,
    /// The path.
    pub path: Path,
    /// Steps taken.
    pub steps: u64,
    /// The time that they took.
    pub time: Duration,
    /// Applications of `A`.
    pub products: u64,
    /// Recursions.
    pub recursions: u64,
    /// Rows of the last LCPs of all steps.
    pub constraints: u64,
    /// The largest overlap of the smooth surfaces.
    pub max_overlap: f64,
    /// The largest overlap of sub-spheres.
    pub proxy_overlap: Option<f64>,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
}

/// Makes a run. A short one is made several times, for its time.
///
/// # Errors
/// [`StudyError`] where a step cannot be taken.
pub fn follow(case: Case) -> Result<Run, StudyError> {
    let scene = case.scene()?;
    let begun = Instant::now();
    let mut run = once(case, &scene)?;
    for _ in 1..REPEATS {
        if begun.elapsed() > REPEAT_WITHIN {
            break;
        }
        run.time = run.time.min(once(case, &scene)?.time);
    }
    Ok(run)
}

/// Makes a run of a case in a scene that is at most in its tolerances another.
pub(super) fn once(case: Case, scene: &Scene) -> Result<Run, StudyError> {
    let stride = ((INTERVAL / case.dt).round() as u64).max(1);
    let mut path = Path::new(stride as f64 * case.dt);
    let begun = Instant::now();
    let bodies = scene.build()?;
    path.push(&bodies.placed(0));
    let mut simulation = Simulation::builder(scene.clone()).bodies(bodies).build()?;
    let mut run = Run {
        case,
        path,
        steps: 0,
        time: Duration::ZERO,
        products: 0,
        recursions: 0,
        constraints: 0,
        max_overlap: 0.0,
        proxy_overlap: None,
        unconverged: 0,
    };
    while !simulation.done() {
        let report = simulation.step()?;
        run.steps += 1;
        run.products += report.products;
        run.recursions += u64::from(report.recursions);
        run.constraints += report.constraints as u64;
        run.max_overlap = run.max_overlap.max(report.max_overlap);
        run.proxy_overlap = report.proxy_overlap.map(|overlap| overlap.max(run.proxy_overlap.unwrap_or(0.0)));
        run.unconverged += u64::from(report.unconverged);
        if run.steps.is_multiple_of(stride) {
            run.path.push(&simulation.state()?.bodies.placed(0));
        }
    }
    run.time = begun.elapsed();
    Ok(run)
}
