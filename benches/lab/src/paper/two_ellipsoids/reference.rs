//! The path that errors are measured against, and how far it may be from the true one.

use super::path::{Case, Path, Scheme, Side, once};
use super::{super::extrapolated, Size};
use crate::StudyError;
use serde::Serialize;

/// The overlap tolerance of the midpoint run, and what the LCPs of all runs of the reference are solved to: with those
/// of the scene, 1e-5 and 1e-6, tolerances count among the smallest errors here. The paper's steps keep the scene's
/// overlap tolerance: they hold it without recursion, and one in some of the steps only would make their error no
/// smooth function of `dt`, which extrapolation needs.
const OVERLAP_TOLERANCE: f64 = 1e-9;
const SOLVER_TOLERANCE: f64 = 1e-10;

/// The reference: fine midpoint steps. Another scheme extrapolated to `dt = 0` says how good it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reference {
    /// To which side the upper body is.
    pub side: Side,
    /// The path.
    #[serde(skip)]
    pub path: Path,
    /// The midpoint step.
    pub midpoint_dt: f64,
    /// The coarser step of the paper's scheme that the other one is extrapolated from; the finer one is half of it.
    pub euler_dt: f64,
    /// The overlap tolerance of the midpoint steps.
    pub tight_overlap_tolerance: f64,
    /// What the LCPs of the reference are solved to.
    pub tight_solver_tolerance: f64,
    /// The overlap tolerance of the scene, and of all runs that are compared.
    pub overlap_tolerance: f64,
    /// The solver's tolerance in these.
    pub solver_tolerance: f64,
    /// How far the two are apart in x, y and angle, in the norm of the errors.
    pub difference: [f64; 3],
}

impl Reference {
    pub(super) fn make(size: &Size, side: Side) -> Result<Self, StudyError> {
        let path = |scheme, dt| -> Result<Path, StudyError> {
            let case = Case { scheme, dt, spheres: None, side };
            let mut scene = case.scene()?;
            scene.solver.tolerance = Some(SOLVER_TOLERANCE);
            if scheme == Scheme::Midpoint {
                scene.contact.overlap_tolerance = OVERLAP_TOLERANCE;
            }
            Ok(once(case, &scene)?.path)
        };
        let fine = path(Scheme::Midpoint, size.reference_midpoint)?;
        let [long, short] = [size.reference_euler, 0.5 * size.reference_euler].map(|dt| path(Scheme::Euler, dt));
        let (long, short) = (long?, short?);
        let samples = [0, 1, 2].map(|i| extrapolated(&long.samples[i], &short.samples[i], 2.0, 1.0));
        let other = Path { interval: long.interval, samples };
        let scene = Case { scheme: Scheme::Euler, dt: size.reference_euler, spheres: None, side }.scene()?;
        Ok(Reference {
            side,
            difference: fine.errors(&other),
            path: fine,
            midpoint_dt: size.reference_midpoint,
            euler_dt: size.reference_euler,
            tight_overlap_tolerance: OVERLAP_TOLERANCE,
            tight_solver_tolerance: SOLVER_TOLERANCE,
            overlap_tolerance: scene.contact.overlap_tolerance,
            solver_tolerance: scene.lcp_settings().tolerance,
        })
    }

    /// The largest of the differences.
    pub fn worst_difference(&self) -> f64 {
        self.difference.into_iter().fold(0.0, f64::max)
    }
}
