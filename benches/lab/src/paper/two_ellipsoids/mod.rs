//! Two ellipsoids pushed past each other: the paper's refinement study (its Table 1 and Figure 3), and the midpoint
//! step beside it.
//!
//! The upper body's centre `x`, `y` and the angle of its long axis are followed; the lower one's path is its mirror
//! image. The paper's errors are "L2 norms"; here that is `sqrt(integral of (x - reference)^2 dt)` over the whole run,
//! the largest of the usual ones for a run of 40 time units. The refinements are made with the upper body to either
//! side, as the paper does not say to which; midpoint steps to the right, the built-in scene.

mod page;
mod path;
mod plot;
mod reference;
mod targets;

pub use path::{Case, Path, Run, Scheme, Side, follow};
pub use reference::Reference;

use super::{Target, l2, order};
use crate::StudyError;
use crate::table::csv_table;
use relcp::figure::Figure;
use serde::Serialize;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Steps of the paper's scheme, from coarse to fine.
    pub euler: &'static [f64],
    /// Steps of the midpoint scheme, from coarse to fine.
    pub midpoint: &'static [f64],
    /// Sub-spheres of a body.
    pub spheres: &'static [u32],
    /// The step with sub-spheres.
    pub multisphere_dt: f64,
    /// The midpoint step of the reference.
    pub reference_midpoint: f64,
    /// The step of the paper's scheme that the reference is compared with, and half of which it is extrapolated from.
    pub reference_euler: f64,
}

impl Size {
    /// Some minutes. With sub-spheres the paper's step, 1e-5, would take an hour.
    pub const FULL: Size = Size {
        euler: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5],
        midpoint: &[0.4, 0.2, 0.1, 0.05, 0.025, 0.0125],
        spheres: &[3, 7, 13, 17, 23, 27],
        multisphere_dt: 1e-4,
        reference_midpoint: 3.125e-4,
        reference_euler: 2e-4,
    };
    /// Some seconds.
    pub const QUICK: Size = Size {
        euler: &[1e-1, 1e-2, 1e-3],
        midpoint: &[0.4, 0.2, 0.1, 0.05, 0.025, 0.0125],
        spheres: &[3, 7],
        multisphere_dt: 1e-2,
        reference_midpoint: 3.125e-3,
        reference_euler: 5e-3,
    };

    /// All runs, in the order in which they are made.
    pub fn cases(&self) -> Vec<Case> {
        let smooth = |scheme, side| move |dt: &f64| Case { scheme, dt: *dt, spheres: None, side };
        let sub_spheres = |side| {
            let dt = self.multisphere_dt;
            move |count: &u32| Case { scheme: Scheme::Multisphere, dt, spheres: Some(*count), side }
        };
        let refined = |side| {
            let euler = self.euler.iter().map(smooth(Scheme::Euler, side));
            euler.chain(self.spheres.iter().map(sub_spheres(side)))
        };
        let midpoint = self.midpoint.iter().map(smooth(Scheme::Midpoint, Side::Right));
        midpoint.chain(refined(Side::Right)).chain(refined(Side::Left)).collect()
    }
}

/// One run of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// To which side the upper body was.
    pub side: Side,
    /// How it was stepped.
    pub scheme: Scheme,
    /// Its step.
    pub dt: f64,
    /// Sub-spheres of a body, where its rows are made from these.
    pub spheres: Option<u32>,
    /// Steps taken.
    pub steps: u64,
    /// Error of the centre's x.
    pub x: f64,
    /// Of its y.
    pub y: f64,
    /// Of the long axis' angle, in radians.
    pub angle: f64,
    /// The largest of the three.
    pub worst: f64,
    /// The error of x over the norm of x.
    pub relative_x: f64,
    /// The same of y.
    pub relative_y: f64,
    /// The same of the angle.
    pub relative_angle: f64,
    /// Error of x against the finest run of the paper's scheme, as in the paper.
    pub x_to_finest: Option<f64>,
    /// The same of y.
    pub y_to_finest: Option<f64>,
    /// The same of the angle.
    pub angle_to_finest: Option<f64>,
    /// The order at which the largest error fell from the run before, of the same scheme.
    pub order: Option<f64>,
    /// Milliseconds of all steps.
    pub milliseconds: f64,
    /// Applications of `A`.
    pub products: u64,
    /// Recursions.
    pub recursions: u64,
    /// Rows of the last LCP of a step, on average.
    pub constraints: f64,
    /// The largest overlap of the smooth surfaces of all steps, a length.
    pub max_overlap: f64,
    /// The largest overlap of sub-spheres.
    pub proxy_overlap: Option<f64>,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
}

/// What was measured so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    size: Size,
    /// To the right, and to the left.
    references: [Reference; 2],
    runs: Vec<Run>,
}

impl Study {
    /// Makes the references.
    ///
    /// # Errors
    /// [`StudyError`] where a run of it cannot be made.
    pub fn begin(size: Size) -> Result<Self, StudyError> {
        let references = [Reference::make(&size, Side::Right)?, Reference::make(&size, Side::Left)?];
        Ok(Study { size, references, runs: Vec::new() })
    }

    /// What it measures.
    pub fn size(&self) -> &Size {
        &self.size
    }

    /// What errors are measured against, with the upper body to the right and to the left.
    pub fn references(&self) -> &[Reference; 2] {
        &self.references
    }

    /// The same with it to one side.
    pub fn reference(&self, side: Side) -> &Reference {
        let [right, left] = &self.references;
        match side {
            Side::Right => right,
            Side::Left => left,
        }
    }

    /// The runs so far.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Makes one more run.
    ///
    /// # Errors
    /// [`StudyError`] where it cannot be made.
    pub fn run(&mut self, case: Case) -> Result<(), StudyError> {
        self.runs.push(follow(case)?);
        Ok(())
    }

    /// The table.
    pub fn rows(&self) -> Vec<Row> {
        let finest = |side: Side| {
            let case = Case { scheme: Scheme::Euler, dt: *self.size.euler.last()?, spheres: None, side };
            self.runs.iter().find(|run| run.case == case).map(|run| &run.path)
        };
        let mut rows: Vec<Row> = Vec::new();
        for run in &self.runs {
            let mut row = self.row(run, finest(run.case.side));
            let same = |before: &&Row| (before.side, before.scheme) == (row.side, row.scheme);
            let before = rows.last().filter(|before| same(before) && row.scheme.has_an_order());
            row.order = before.and_then(|before| order([before.dt, row.dt], [before.worst, row.worst]));
            rows.push(row);
        }
        rows
    }

    fn row(&self, run: &Run, finest: Option<&Path>) -> Row {
        let reference = &self.reference(run.case.side).path;
        let [x, y, angle] = run.path.errors(reference);
        let size = reference.norms();
        let to_finest = finest.map(|finest| run.path.errors(finest));
        Row {
            side: run.case.side,
            scheme: run.case.scheme,
            dt: run.case.dt,
            spheres: run.case.spheres,
            steps: run.steps,
            x,
            y,
            angle,
            worst: x.max(y).max(angle),
            relative_x: x / size[0],
            relative_y: y / size[1],
            relative_angle: angle / size[2],
            x_to_finest: to_finest.map(|errors| errors[0]),
            y_to_finest: to_finest.map(|errors| errors[1]),
            angle_to_finest: to_finest.map(|errors| errors[2]),
            order: None,
            milliseconds: 1e3 * run.time.as_secs_f64(),
            products: run.products,
            recursions: run.recursions,
            constraints: run.constraints as f64 / run.steps.max(1) as f64,
            max_overlap: run.max_overlap,
            proxy_overlap: run.proxy_overlap,
            unconverged: run.unconverged,
        }
    }

    /// What it is to show, and whether it does.
    pub fn targets(&self) -> Vec<Target> {
        targets::targets(&self.rows(), &self.references)
    }

    /// Whether a run of smooth surfaces did not hold its overlap tolerance, or a solve its own.
    pub fn missed(&self) -> bool {
        self.runs.iter().any(|run| {
            let allowed = self.reference(run.case.side).overlap_tolerance;
            run.unconverged > 0 || (run.case.spheres.is_none() && run.max_overlap > allowed)
        })
    }

    /// The page, without its plots.
    pub fn page(&self) -> String {
        page::page(self)
    }

    /// The table as CSV.
    ///
    /// # Errors
    /// [`StudyError::Table`].
    pub fn csv(&self) -> Result<Vec<u8>, StudyError> {
        csv_table(self.rows().iter())
    }

    /// The plots: errors over work, and paths.
    ///
    /// # Errors
    /// [`StudyError::Plot`].
    pub fn plots(&self) -> Result<[(&'static str, Figure); 2], StudyError> {
        Ok([("two-ellipsoids-work", plot::work(self)?), ("two-ellipsoids-paths", plot::paths(self)?)])
    }
}

#[cfg(test)]
mod tests;
