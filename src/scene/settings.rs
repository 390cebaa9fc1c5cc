//! What a scene's settings mean to a step and to a recorder, with the defaults that depend on other settings.

use super::{Contact, Dump, Method, Recursion, Rows, SMALLEST_NUMBER, Scene};
use crate::constraint::RowSource;
use crate::lcp::Settings;
use crate::shape::Shape;

/// A solver stops at this part of the overlap tolerance, so that the linear solve adds little to what the recursion measures.
const TOLERANCE_PER_OVERLAP: f64 = 0.1;

/// Iterations that any LCP of the built-in scenes is solved in by the default solver, and by none that has stalled.
const MOST_ITERATIONS: u64 = 100_000;

/// The default cutoff is this part of the thinnest body's thickness. It only decides which pairs get a row before the first trial
/// shows that they need one, beside those that the free motion may bring into contact. Between 1/4 and 1/400 neither the recursions
/// nor the products of a packed compaction (1,000 ellipsoids, dt = 0.1) or of a colony change by more than 3 %, while the rows fall by 15 %
/// and 8 %; two thirds of that are had at 1/10.
const CUTOFF_PER_THICKNESS: f64 = 0.1;

/// Recorded states of a run, where a scene does not say: a film of some seconds.
const STATES: f64 = 100.0;

impl Scene {
    /// When the LCP solver stops: as given, or at a tenth of the overlap tolerance and after 100,000 iterations.
    ///
    /// ```
    /// let scene = relcp::scene::load("colony", &["solver.max_iterations=5".into()])?;
    /// let settings = scene.lcp_settings();
    /// assert_eq!((settings.tolerance, settings.max_iterations), (0.1 * scene.contact.overlap_tolerance, 5));
    /// # Ok::<(), relcp::scene::SceneError>(())
    /// ```
    pub fn lcp_settings(&self) -> Settings {
        // No smaller than a scene may say, so that what is written out can be read.
        let default = (TOLERANCE_PER_OVERLAP * self.contact.overlap_tolerance).max(SMALLEST_NUMBER);
        Settings {
            tolerance: self.solver.tolerance.unwrap_or(default),
            max_iterations: self.solver.max_iterations.unwrap_or(MOST_ITERATIONS),
        }
    }

    /// Distance within which pairs are near at a step's start: as given, or a tenth of the thinnest starting body's thickness
    /// (growth and division leave it as it is).
    pub fn cutoff(&self) -> f64 {
        self.cutoff_of(self.shapes().map(|(_, _, shape)| shape))
    }

    /// As [`Scene::cutoff`], where the bodies are not the scene's own.
    pub fn cutoff_of(&self, shapes: impl Iterator<Item = Shape>) -> f64 {
        let default = || CUTOFF_PER_THICKNESS * shapes.map(|shape| shape.thickness()).reduce(f64::min).unwrap_or(0.0);
        self.contact.cutoff.unwrap_or_else(default)
    }

    /// The thinnest starting body's thickness; infinite where there is no body.
    pub(crate) fn thinnest(&self) -> f64 {
        self.shapes().map(|(_, _, shape)| shape.thickness()).fold(f64::INFINITY, f64::min)
    }

    /// Time between recorded states: as given, or a hundredth of the run. `None` where the run has no duration.
    pub fn output_every(&self) -> Option<f64> {
        let duration = self.time.end - self.time.start;
        self.output.every.or((duration > 0.0).then_some((duration / STATES).max(SMALLEST_NUMBER)))
    }

    /// This scene with every default that depends on other keys written out.
    pub fn with_defaults(&self) -> Scene {
        let mut scene = self.clone();
        let Settings { tolerance, max_iterations } = self.lcp_settings();
        scene.contact.recursion = self.recursion();
        scene.solver.tolerance = Some(tolerance);
        scene.solver.max_iterations = Some(max_iterations);
        scene.solver.dump = self.solver.dump.map(Dump::with_defaults);
        scene.contact.cutoff = Some(self.cutoff());
        scene.output.every = self.output_every();
        scene
    }
}

impl Scene {
    /// How tightly the solves before a step's last one are made: exactly or inexactly.
    pub fn recursion(&self) -> Recursion {
        match self.contact.recursion {
            Recursion::Auto => {
                let inexact =
                    !self.planar && self.contact.rows_of_method() == Rows::Auto && self.solver.tolerance.is_none();
                if inexact { Recursion::Inexact } else { Recursion::Exact }
            }
            given => given,
        }
    }
}

impl Contact {
    /// How rows are made: methods without recursion have the paper's.
    pub fn rows_of_method(&self) -> Rows {
        if self.method == Method::Relcp { self.rows } else { Rows::Paper }
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
