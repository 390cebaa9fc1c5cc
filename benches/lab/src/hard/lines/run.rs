//! The runs of a row with several step sizes, and their results.

use super::{Kind, Line};
use crate::StudyError;
use crate::hard::Size;
use crate::hard::moves::worse;
use crate::hard::threads::spread;
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::Scene;
use relcp::simulation::Simulation;
use serde::Serialize;

/// Two decades of steps.
const DT: [f64; 5] = [0.05, 0.02, 0.01, 0.002, 5e-4];
/// Those of a quick study.
const QUICK_DT: [f64; 2] = [0.05, 0.02];
/// The step of the run that others are held against: a thousandth of the longest, a tenth of the shortest.
const REFERENCE: f64 = 5e-5;
const QUICK_REFERENCE: f64 = 2e-3;
/// Errors against a closed form at most: those of a step of 0.05 are under 1e-3.
const MOST_ERROR: f64 = 0.01;
/// How far contact may move a body in a step, in its thickness.
const MOST_MOVE: f64 = 0.5;

/// A row that was run with one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What was run.
    pub line: Line,
    /// With steps of this.
    pub dt: f64,
    /// Steps taken.
    pub steps: u64,
    /// The fault that stopped it, or what refused it.
    pub fault: Option<String>,
    /// The largest distance of two centres across the row at the end.
    pub offset: f64,
    /// What two balls' should be.
    pub right_offset: Option<f64>,
    /// How far that is off; of other rows the largest difference of two points' distance from that of a run with a
    /// small step. None where there is nothing to compare with.
    pub error: Option<f64>,
    /// The farthest that contact moved a centre in a step, in the thickness of the body.
    pub largest_move: f64,
    /// Solves a step: one a piece and one a recursion.
    pub solves: f64,
    /// Steps in pieces.
    pub steps_cut: u64,
    /// The largest overlap that a step reported.
    pub max_overlap: f64,
    /// The centres and the ends of all bodies at the end.
    #[serde(skip)]
    pub points: Vec<DVec3>,
}

impl Row {
    /// Whether it ended, nobody was thrown, and two balls are where they should be.
    pub fn is_well(&self) -> bool {
        let near = self.right_offset.is_none() || self.error.is_some_and(|error| error <= MOST_ERROR);
        self.fault.is_none() && self.largest_move <= MOST_MOVE && near
    }
}

/// Runs rows with all step sizes, several rows at once. `seen` is called when the runs of a row end.
///
/// # Errors
/// [`StudyError::Threads`].
pub fn run_all(
    lines: &[Line],
    size: Size,
    threads: usize,
    seen: &(dyn Fn(&[Row]) + Sync),
) -> Result<Vec<Row>, StudyError> {
    let (steps, reference) = match size == Size::QUICK {
        true => (&QUICK_DT[..], QUICK_REFERENCE),
        false => (&DT[..], REFERENCE),
    };
    let all = spread(lines.len(), threads, &|number| {
        let rows = run(&lines[number], steps, reference);
        seen(&rows);
        rows
    })?;
    Ok(all.concat())
}

/// Runs a row at some steps, held against a closed form or against a run with steps of `reference`.
pub fn run(line: &Line, steps: &[f64], reference: f64) -> Vec<Row> {
    // What is in line gives way by chance, and what has inertia flies the faster the shorter the step is.
    let compares = line.right_offset().is_none() && !line.inertial && line.misalignment > 0.0;
    let against = compares.then(|| follow(line, reference)).filter(|row| row.fault.is_none());
    let one = |dt: &f64| {
        let mut row = follow(line, *dt);
        row.error = match (row.right_offset, &against) {
            _ if row.fault.is_some() => None,
            (Some(right), _) => Some((row.offset - right).abs()),
            (None, Some(reference)) => Some(apart(&row.points, &reference.points)),
            (None, None) => None,
        };
        row
    };
    steps.iter().map(one).collect()
}

/// The largest difference of the distances of two points: it does not care which way a row gives.
fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    let pairs = (0..a.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|(i, j)| ((a[i] - a[j]).length() - (b[i] - b[j]).length()).abs()).fold(0.0, worse)
}

fn follow(line: &Line, dt: f64) -> Row {
    let mut row = Row {
        line: *line,
        dt,
        steps: 0,
        fault: None,
        offset: f64::NAN,
        right_offset: line.right_offset(),
        error: None,
        largest_move: 0.0,
        solves: 0.0,
        steps_cut: 0,
        max_overlap: 0.0,
        points: Vec::new(),
    };
    let mut solves = 0;
    let taken = row.take(line.start(dt).scene, &mut solves);
    row.fault = taken.err().map(|error| error.to_string());
    row.solves = f64::from(solves) / row.steps.max(1) as f64;
    row
}

impl Row {
    fn take(&mut self, scene: Scene, solves: &mut u32) -> Result<(), relcp::Error> {
        let inertial = scene.dynamics.has_inertia();
        let mut simulation = Simulation::new(scene)?;
        let mut before = simulation.state()?.bodies.clone();
        self.measure(&before);
        while !simulation.done() {
            let report = simulation.step()?;
            let after = &simulation.state()?.bodies;
            let moved = (0..after.len()).map(|i| {
                let free = if inertial { self.dt * before.velocity[i] } else { DVec3::ZERO };
                (after.position[i] - before.position[i] - free).length() / after.shape[i].thickness()
            });
            self.largest_move = moved.fold(self.largest_move, worse);
            self.steps += 1;
            self.steps_cut += u64::from(report.pieces > 1);
            self.max_overlap = self.max_overlap.max(report.max_overlap);
            *solves += report.recursions + report.pieces.max(1);
            before.clone_from(after);
            self.measure(&before);
        }
        Ok(())
    }

    fn measure(&mut self, bodies: &Bodies) {
        let aside: Vec<DVec3> = bodies.position.iter().map(|x| x.with_x(0.0)).collect();
        let pairs = (0..aside.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        self.offset = pairs.map(|(i, j)| (aside[i] - aside[j]).length()).fold(0.0, worse);
        let round = matches!(self.line.kind, Kind::Balls | Kind::InSphere);
        let ends = |i: usize| {
            let axis = bodies.orientation[i] * DVec3::Z;
            let ends = [axis, -axis].map(|end| bodies.position[i] + end);
            [bodies.position[i]].into_iter().chain(ends.into_iter().filter(move |_| !round))
        };
        self.points = (0..bodies.len()).flat_map(ends).collect();
    }
}
