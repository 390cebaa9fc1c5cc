//! One run of three capsules.

use super::Shake;
use crate::StudyError;
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::{self, Rows, Scene};
use relcp::simulation::Simulation;
use serde::Serialize;

/// Most lines of a run's course over time: steps are taken together where there are more.
const MOST_WINDOWS: u64 = 100;

/// The forces that press: on the outer capsules, along y.
pub(super) const PRESS: [&str; 3] = [
    "bodies.0.group=lower",
    "bodies.2.group=upper",
    r#"forces=[{"uniform":{"force":[0,1,0],"group":"lower"}},{"uniform":{"force":[0,-1,0],"group":"upper"}}]"#,
];

/// Which capsules.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Capsules {
    /// The paper's, which overlap at the start and are left alone.
    Alone,
    /// The same, pressed together by forces.
    Pressed,
}

impl Capsules {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Capsules::Alone => "left alone",
            Capsules::Pressed => "pressed together",
        }
    }
}

/// How contacts are resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// By ReLCP.
    Relcp,
    /// By one row a pair.
    Snsd,
}

impl Method {
    /// Both.
    pub const BOTH: [Method; 2] = [Method::Relcp, Method::Snsd];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Method::Relcp => "ReLCP",
            Method::Snsd => "LCP-SNSD",
        }
    }
}

/// A run that is to be made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Case {
    /// Which capsules.
    pub capsules: Capsules,
    /// How contacts are resolved.
    pub method: Method,
    /// The step.
    pub dt: f64,
}

impl Case {
    /// Its name.
    pub fn name(&self) -> String {
        format!("{}, {}, dt {:e}", self.capsules.name(), self.method.name(), self.dt)
    }

    fn scene(&self, steps: u64) -> Result<Scene, StudyError> {
        let press = if self.capsules == Capsules::Pressed { &PRESS[..] } else { &[] };
        let mut sets: Vec<String> = press.iter().map(|set| (*set).to_owned()).collect();
        sets.push(format!("time.dt={}", self.dt));
        sets.push(format!("time.end={}", self.dt * steps as f64));
        let mut scene = Scene::load("three-capsules", &sets)?;
        scene.contact.rows = Rows::Paper;
        scene.contact.method = match self.method {
            Method::Relcp => scene::Method::Relcp,
            Method::Snsd => scene::Method::Snsd,
        };
        Ok(scene)
    }
}

/// Some steps of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Window {
    /// Which capsules.
    pub capsules: Capsules,
    /// How contacts are resolved.
    pub method: Method,
    /// The step.
    pub dt: f64,
    /// The last of the steps.
    pub step: u64,
    /// Time after it.
    pub time: f64,
    /// How many they are.
    pub steps: u64,
    /// Their largest overlap, a length.
    pub max_overlap: f64,
    /// Their jitter, a length; none before three states are known.
    pub jitter: Option<f64>,
    /// Their displacement a step.
    pub displacement: f64,
    /// Recursions.
    pub recursions: u64,
}

/// A run that was made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// What was run.
    pub case: Case,
    /// Steps taken.
    pub steps: u64,
    /// The overlap tolerance.
    pub overlap_tolerance: f64,
    /// The overlap after the first step, a length.
    pub first_overlap: f64,
    /// The largest of all steps.
    pub max_overlap: f64,
    /// The largest of the second half of the steps.
    pub late_overlap: f64,
    /// Steps that left more than the tolerance.
    pub steps_over: u64,
    /// The first step from which on none did.
    pub resolved_at: Option<u64>,
    /// Of all steps.
    pub whole: Shake,
    /// Of the second half of the steps.
    pub late: Shake,
    /// Recursions.
    pub recursions: u64,
    /// Applications of `A`.
    pub products: u64,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
    /// Its windows over time.
    #[serde(skip)]
    pub windows: Vec<Window>,
}

/// Performs a run with this number of steps.
///
/// # Errors
/// [`StudyError`] where a step cannot be taken.
pub fn follow(case: Case, steps: u64) -> Result<Run, StudyError> {
    let scene = case.scene(steps)?;
    let bodies = scene.build()?;
    let mut run = Run::new(case, scene.contact.overlap_tolerance);
    let mut frames = vec![tips(&bodies)];
    let mut simulation = Simulation::builder(scene).bodies(bodies).build()?;
    let width = steps.div_ceil(MOST_WINDOWS).max(1);
    let mut window = Shake::default();
    while simulation.steps() < steps {
        let report = simulation.step()?;
        if frames.len() == 3 {
            frames.remove(0);
        }
        frames.push(tips(&simulation.state()?.bodies));
        let shake = Shake::of(&frames);
        run.count(&report, &shake, 2 * report.step > steps);
        if (report.step - 1) % width == 0 {
            window = Shake::default();
            run.windows.push(Window::new(case));
        }
        window.add(&shake);
        if let Some(line) = run.windows.last_mut() {
            line.step = report.step;
            line.time = report.time;
            line.steps += 1;
            line.max_overlap = line.max_overlap.max(report.max_overlap);
            line.jitter = (report.step > 1).then(|| window.jitter());
            line.displacement = window.displacement();
            line.recursions += u64::from(report.recursions);
        }
    }
    Ok(run)
}

impl Window {
    fn new(Case { capsules, method, dt }: Case) -> Self {
        Window {
            capsules,
            method,
            dt,
            step: 0,
            time: 0.0,
            steps: 0,
            max_overlap: 0.0,
            jitter: None,
            displacement: 0.0,
            recursions: 0,
        }
    }
}

impl Run {
    fn new(case: Case, overlap_tolerance: f64) -> Self {
        Run {
            case,
            steps: 0,
            overlap_tolerance,
            first_overlap: 0.0,
            max_overlap: 0.0,
            late_overlap: 0.0,
            steps_over: 0,
            resolved_at: None,
            whole: Shake::default(),
            late: Shake::default(),
            recursions: 0,
            products: 0,
            unconverged: 0,
            windows: Vec::new(),
        }
    }

    fn count(&mut self, report: &relcp::step::StepReport, shake: &Shake, late: bool) {
        self.steps = report.step;
        if report.step == 1 {
            self.first_overlap = report.max_overlap;
        }
        self.max_overlap = self.max_overlap.max(report.max_overlap);
        if report.max_overlap > self.overlap_tolerance {
            self.steps_over += 1;
            self.resolved_at = None;
        } else {
            self.resolved_at = self.resolved_at.or(Some(report.step));
        }
        self.whole.add(shake);
        if late {
            self.late.add(shake);
            self.late_overlap = self.late_overlap.max(report.max_overlap);
        }
        self.recursions += u64::from(report.recursions);
        self.products += report.products;
        self.unconverged += u64::from(report.unconverged);
    }
}

/// Both tips of every rod.
fn tips(bodies: &Bodies) -> Vec<DVec3> {
    let tip = |i: usize, side: f64| {
        bodies.position[i] + side * (bodies.orientation[i] * DVec3::Z) * bodies.shape[i].bounding_radius()
    };
    (0..bodies.len()).flat_map(|i| [tip(i, -1.0), tip(i, 1.0)]).collect()
}
