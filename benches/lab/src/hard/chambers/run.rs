//! The run of a chamber and its record.

use super::{Chamber, POPULATION, chamber, overflowing};
use crate::StudyError;
use crate::hard::moves::farthest;
use crate::hard::threads::spread;
use relcp::Error;
use relcp::bodies::Bodies;
use relcp::simulation::Simulation;
use relcp::step::StepReport;
use serde::Serialize;
use std::time::{Duration, Instant};

/// How a chamber's run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// It overflowed for two generations.
    Overflowed,
    /// It had as many cells as a run may have.
    Population,
    /// It reached the latest end without overflow or standstill.
    Time,
    /// All its cells waited, step after step: nothing will change.
    Frozen,
    /// No cell was left.
    Empty,
    /// It reached the requested number of steps.
    Steps,
    /// A fault stopped it: its name and its message.
    Fault(&'static str, String),
    /// It could not begin.
    Refused(String),
}

impl End {
    /// Its name in tables.
    pub fn name(&self) -> &str {
        match self {
            End::Overflowed => "overflowed",
            End::Population => "population",
            End::Time => "end of time",
            End::Frozen => "frozen",
            End::Empty => "empty",
            End::Steps => "steps",
            End::Fault(name, _) => name,
            End::Refused(_) => "refused",
        }
    }
}

/// Steps in a row in which all cells wait after which a chamber is frozen for good.
const FROZEN: u64 = 20;
/// Numbers of cells about which steps are timed, and how far from them.
const TIMED: [f64; 3] = [60.0, 120.0, 300.0];
const ABOUT: f64 = 0.1;

/// A chamber that was run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its number.
    pub number: u64,
    /// The distance of its sides, in diameters.
    pub width: f64,
    /// The height at which cells leave, in diameters.
    pub height: f64,
    /// The floor's angle, degrees.
    pub tilt: f64,
    /// The step.
    pub dt: f64,
    /// How it ended.
    pub end: End,
    /// The time of the end.
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Cells at the end.
    pub cells: usize,
    /// The largest number of cells.
    pub most_cells: usize,
    /// Cells that left in all.
    pub removed: u64,
    /// The most that left in one step.
    pub most_leaving: usize,
    /// The largest move in a step of the centre of a cell that stayed.
    pub largest_move: f64,
    /// The step of it.
    pub moved_in_step: u64,
    /// Recursions per step.
    pub recursions: f64,
    /// Solves per step: one per piece and one per recursion.
    pub solves: f64,
    /// Steps that were taken in pieces.
    pub steps_cut: u64,
    /// Steps in which cells waited.
    pub steps_waiting: u64,
    /// Steps that ended the run for lack of room: 0 or 1.
    pub no_room: u32,
    /// The largest overlap that a step reported.
    pub max_overlap: f64,
    /// Wall seconds per step with about 60 cells; `None` if there were never so many.
    pub seconds_at_60: Option<f64>,
    /// The same with about 120 cells, the capacity of most chambers.
    pub seconds_at_120: Option<f64>,
    /// The same with about 300 cells.
    pub seconds_at_300: Option<f64>,
    /// Wall seconds of all steps.
    pub seconds: f64,
}

/// A cell that moves so far in a step is thrown: it grows by a hundredth of a diameter in one.
const MOST_MOVE: f64 = 0.5;

/// Cells that leave in one step at most: of 12 chambers 3 where none was thrown, and from 8 on where some were.
const MOST_LEAVING: usize = 4;

impl Row {
    /// Whether its run went to where a chamber's run is to end, and no cell was thrown, nor thrown out.
    pub fn is_well(&self) -> bool {
        let ended = matches!(self.end, End::Overflowed | End::Population | End::Steps);
        ended && self.largest_move <= MOST_MOVE && self.most_leaving <= MOST_LEAVING
    }
}

/// Runs chambers `0..count` of a seed on several threads. `seen` is called when a chamber ends. The rows are in order
/// and, except for times, independent of the threads.
///
/// # Errors
/// [`StudyError::Threads`].
pub fn run_all(
    [seed, count]: [u64; 2],
    stalls: bool,
    most_steps: u64,
    threads: usize,
    seen: &(dyn Fn(&Row, &Chamber) + Sync),
) -> Result<Vec<Row>, StudyError> {
    spread(count as usize, threads, &|number| {
        let chamber = chamber(seed, number as u64, stalls);
        let row = run(&chamber, most_steps);
        seen(&row, &chamber);
        row
    })
}

/// Runs a chamber.
pub fn run(chamber: &Chamber, most_steps: u64) -> Row {
    let mut run = ChamberRun::new(chamber);
    let end = run.follow(chamber, most_steps);
    run.row(end)
}

/// A chamber run so far.
struct ChamberRun {
    row: Row,
    recursions: u64,
    solves: u64,
    timed: [(Duration, u32); 3],
    overflows_since: Option<f64>,
    waited: u64,
}

impl ChamberRun {
    fn new(chamber: &Chamber) -> ChamberRun {
        let Chamber { number, width, height, tilt, scene } = chamber;
        let row = Row {
            number: *number,
            width: *width,
            height: *height,
            tilt: *tilt,
            dt: scene.time.dt,
            end: End::Steps,
            time: 0.0,
            steps: 0,
            cells: scene.bodies.len(),
            most_cells: scene.bodies.len(),
            removed: 0,
            most_leaving: 0,
            largest_move: 0.0,
            moved_in_step: 0,
            recursions: 0.0,
            solves: 0.0,
            steps_cut: 0,
            steps_waiting: 0,
            no_room: 0,
            max_overlap: 0.0,
            seconds_at_60: None,
            seconds_at_120: None,
            seconds_at_300: None,
            seconds: 0.0,
        };
        ChamberRun { row, recursions: 0, solves: 0, timed: Default::default(), overflows_since: None, waited: 0 }
    }

    fn follow(&mut self, chamber: &Chamber, most_steps: u64) -> End {
        match self.take(chamber, most_steps) {
            Ok(end) => end,
            Err(Error::Fault(fault)) => {
                self.row.no_room = u32::from(fault.name() == "no_room");
                End::Fault(fault.name(), fault.to_string())
            }
            Err(error) => End::Refused(error.to_string()),
        }
    }

    fn take(&mut self, chamber: &Chamber, most_steps: u64) -> Result<End, Error> {
        let mut simulation = Simulation::new(chamber.scene.clone())?;
        let mut before = simulation.state()?.bodies.clone();
        loop {
            if let Some(end) = self.ended(&simulation, most_steps) {
                return Ok(end);
            }
            let begun = Instant::now();
            let report = simulation.step()?;
            let took = begun.elapsed();
            let after = &simulation.state()?.bodies;
            self.see(&report, &before, after, took);
            before.clone_from(after);
        }
    }

    fn ended(&self, simulation: &Simulation, most_steps: u64) -> Option<End> {
        let cells = simulation.bodies() as u64;
        let overflowed = self.overflows_since.is_some_and(|since| simulation.time() >= since + overflowing());
        let ends = [
            (cells == 0, End::Empty),
            (cells >= POPULATION, End::Population),
            (overflowed, End::Overflowed),
            (self.waited >= FROZEN, End::Frozen),
            (simulation.done(), End::Time),
            (self.row.steps >= most_steps, End::Steps),
        ];
        ends.into_iter().find(|(is, _)| *is).map(|(_, end)| end)
    }

    fn see(&mut self, report: &StepReport, before: &Bodies, after: &Bodies, took: Duration) {
        let row = &mut self.row;
        (row.steps, row.time, row.cells) = (row.steps + 1, report.time, after.len());
        row.most_cells = row.most_cells.max(after.len());
        row.removed += report.removed as u64;
        row.most_leaving = row.most_leaving.max(report.removed);
        let (way, _) = farthest(before, after);
        if way > row.largest_move || way.is_nan() {
            (row.largest_move, row.moved_in_step) = (way, report.step);
        }
        row.steps_cut += u64::from(report.pieces > 1);
        row.steps_waiting += u64::from(report.waiting > 0);
        row.max_overlap = row.max_overlap.max(report.max_overlap);
        row.seconds += took.as_secs_f64();
        self.recursions += u64::from(report.recursions);
        self.solves += u64::from(report.recursions + report.pieces.max(1));
        self.waited = if report.waiting >= before.len() { self.waited + 1 } else { 0 };
        if report.removed > 0 {
            self.overflows_since.get_or_insert(report.time);
        }
        for (timed, cells) in self.timed.iter_mut().zip(TIMED) {
            if (before.len() as f64 - cells).abs() <= ABOUT * cells {
                *timed = (timed.0 + took, timed.1 + 1);
            }
        }
    }

    fn row(self, end: End) -> Row {
        let steps = self.row.steps.max(1) as f64;
        let [at_60, at_120, at_300] =
            self.timed.map(|(all, steps)| (steps > 0).then(|| all.as_secs_f64() / f64::from(steps)));
        Row {
            end,
            recursions: self.recursions as f64 / steps,
            solves: self.solves as f64 / steps,
            seconds_at_60: at_60,
            seconds_at_120: at_120,
            seconds_at_300: at_300,
            ..self.row
        }
    }
}
