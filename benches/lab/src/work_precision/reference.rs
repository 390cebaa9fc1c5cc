//! Reference solutions, which define the errors of ends, and estimates of their own errors.
//!
//! A reference is the end of the finest affordable midpoint run. The paper's step at two sizes, extrapolated to zero,
//! gives the same end by another scheme. The distance between the two is the error estimate of the reference.
//! Tolerances are so tight that their effect is negligible. The paper's steps keep an overlap tolerance that they hold
//! without recursion where there is one: rows appended in some of the steps only would make their error no smooth
//! function of the step, which extrapolation needs (two ellipsoids: 4e-8 apart so, 3e-5 at 1e-10).

use super::pose::{Apart, Pose, apart, limit, poses};
use super::problem::Problem;
use crate::StudyError;
use relcp::scene::Stepping;
use relcp::simulation::Simulation;
use serde::{Deserialize, Serialize};

/// A reference is accurate enough for errors of at least this multiple of its own estimate.
pub const CERTAINTY: f64 = 3.0;

/// The format of a reference's file.
const FORMAT: &str = "relcp-reference 1";

/// How the runs that a reference is made from are stepped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Making {
    /// Steps of the midpoint run.
    pub midpoint_steps: u64,
    /// Its overlap tolerance.
    pub midpoint_tolerance: f64,
    /// Of the coarser run of the paper's step; the finer one takes twice as many.
    pub euler_steps: u64,
    /// The overlap tolerance of these two.
    pub euler_tolerance: f64,
    /// What the LCPs of all three are solved to.
    pub solver_tolerance: f64,
}

/// A reference solution, as its file holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    format: String,
    /// What it is a solution of.
    pub problem: String,
    /// The [hash](Problem::hash) of that.
    pub hash: String,
    /// The time of the end.
    pub time: f64,
    /// What lengths are measured in.
    pub length: f64,
    /// How it was made.
    pub made: Making,
    /// Solves that did not reach their tolerance, of all three runs.
    pub unconverged: u64,
    /// How far the two schemes are apart.
    pub estimate: Apart,
    /// Where the bodies end.
    pub bodies: Vec<Pose>,
}

impl Reference {
    /// Makes it anew.
    ///
    /// # Errors
    /// [`StudyError`] where a run of it cannot be made, or runs end with different bodies.
    pub fn make(problem: &Problem, made: Making) -> Result<Self, StudyError> {
        let mut unconverged = 0;
        let mut end = |stepping, steps, tolerance| -> Result<Vec<Pose>, StudyError> {
            let mut scene = problem.scene()?;
            scene.time.dt = problem.end / steps as f64;
            scene.time.stepping = stepping;
            scene.contact.overlap_tolerance = tolerance;
            scene.solver.tolerance = Some(made.solver_tolerance);
            let mut simulation = Simulation::new(scene)?;
            while !simulation.done() {
                unconverged += u64::from(simulation.step()?.unconverged);
            }
            Ok(poses(&simulation.state()?.bodies))
        };
        let bodies = end(Stepping::Midpoint, made.midpoint_steps, made.midpoint_tolerance)?;
        let coarse = end(Stepping::Euler, made.euler_steps, made.euler_tolerance)?;
        let fine = end(Stepping::Euler, 2 * made.euler_steps, made.euler_tolerance)?;
        let length = problem.length()?;
        let estimate = limit(&coarse, &fine).and_then(|limit| apart(&bodies, &limit, length));
        let differ = || StudyError::Reference(format!("{}: runs end with different bodies", problem.name));
        Ok(Reference {
            format: FORMAT.into(),
            problem: problem.name.into(),
            hash: problem.hash()?,
            time: problem.end,
            length,
            made,
            unconverged,
            estimate: estimate.ok_or_else(differ)?,
            bodies,
        })
    }

    /// Reads the one that is stored of a problem.
    ///
    /// # Errors
    /// [`StudyError::Reference`] where it is damaged, or that of another scene than the problem is now.
    pub fn stored(problem: &Problem) -> Result<Self, StudyError> {
        Self::read(problem, problem.stored)
    }

    fn read(problem: &Problem, text: &str) -> Result<Self, StudyError> {
        let fault = |what: String| StudyError::Reference(format!("{}: {what}", problem.name));
        let reference: Reference = serde_json::from_str(text).map_err(|e| fault(e.to_string()))?;
        if reference.format != FORMAT {
            return Err(fault(format!("its format is `{}`, not `{FORMAT}`", reference.format)));
        }
        let hash = problem.hash()?;
        if reference.hash != hash {
            let of = reference.hash;
            return Err(fault(format!("it is of a scene with the hash {of}, and the scene's is {hash}; make it anew")));
        }
        Ok(reference)
    }

    /// Its file.
    ///
    /// # Errors
    /// [`StudyError::Table`].
    pub fn text(&self) -> Result<String, StudyError> {
        serde_json::to_string_pretty(self).map(|text| text + "\n").map_err(|e| StudyError::Table(e.to_string()))
    }

    /// Whether an error is so large that this solution's own does not count.
    pub fn settles(&self, error: f64) -> bool {
        error >= CERTAINTY * self.estimate.worst()
    }

    /// How far an end of the same problem is from it; `None` where it is of other bodies.
    pub fn error(&self, end: &[Pose]) -> Option<Apart> {
        apart(end, &self.bodies, self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::PROBLEMS;
    use super::*;

    #[test]
    fn a_reference_of_another_scene_or_format_is_refused() {
        let problem = &PROBLEMS[0];
        let reference = Reference::stored(problem).unwrap();
        assert_eq!(Reference::read(problem, &reference.text().unwrap()).unwrap(), reference);
        let refused = |text: String| Reference::read(problem, &text).unwrap_err().to_string();
        let other = Reference { hash: "0123456789abcdef".into(), ..reference.clone() };
        assert!(refused(other.text().unwrap()).contains("0123456789abcdef, and the scene's is"));
        let other = Reference { format: "relcp-reference 9".into(), ..reference.clone() };
        assert!(refused(other.text().unwrap()).contains("`relcp-reference 9`"));
        assert!(refused(reference.text().unwrap().replace("\"estimate\"", "\"guess\"")).contains("guess"));
        assert!(Reference::stored(&Problem { end: 39.0, ..*problem }).is_err());
    }
}
