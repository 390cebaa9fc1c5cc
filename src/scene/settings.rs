//! What a scene's method and solver mean to a step, with the defaults that depend on other settings.

use super::{Method, Solver};
use crate::constraint::RowSource;
use crate::lcp::Settings;

/// A solver stops at this part of the overlap tolerance, so that the linear solve adds little to what the recursion measures.
const TOLERANCE_PER_OVERLAP: f64 = 0.1;

/// Iterations that any LCP of the built-in scenes is solved in by the default solver, and by none that has stalled.
const MOST_ITERATIONS: u64 = 100_000;

impl Solver {
    /// When it stops, in a scene with this overlap tolerance.
    pub fn settings(&self, overlap_tolerance: f64) -> Settings {
        Settings {
            tolerance: self.tolerance.unwrap_or(TOLERANCE_PER_OVERLAP * overlap_tolerance),
            max_iterations: self.max_iterations.unwrap_or(MOST_ITERATIONS),
        }
    }
}

impl Method {
    /// What its rows are made from.
    pub fn row_source(&self) -> RowSource {
        match *self {
            Method::Relcp | Method::Snsd => RowSource::Surfaces,
            Method::Multisphere { count } => RowSource::SubSpheres { count },
        }
    }

    /// Most recursions of a step, where a scene allows `allowed`.
    pub fn most_recursions(&self, allowed: u32) -> u32 {
        match self {
            Method::Relcp => allowed,
            Method::Snsd | Method::Multisphere { .. } => 0,
        }
    }
}
