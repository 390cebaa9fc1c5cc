//! Solvers: the cost and the accuracy of each, on stored LCPs and in short runs.
//!
//! A stored LCP is solved from zero and from its stored start, with several tolerances. The reported residual is
//! recomputed from `q`, `J` and `gamma` ([`Stored::residual`]). The velocity `J^T gamma`, which is unique, is compared
//! with a reference.

mod instance;
mod page;
mod plot;
mod runs;

pub use instance::{Attempt, Curve, Instance, Reference, Start, measure};
pub use page::{attempts_csv, page, runs_csv};
pub use plot::plot;
pub use runs::{RunRow, run_cases};

use relcp::lcp::Stored;
use relcp::record::{LcpFileError, decode_lcp};
use relcp::scene::SolverKind;

/// The tolerances of the solves, lengths: a loose one, the overlap tolerance of a step, and the solver tolerance of a
/// step.
pub const TOLERANCES: [f64; 3] = [1e-3, 1e-5, 1e-6];

/// The extent of the measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Size {
    /// The largest number of iterations of a solve of a stored LCP.
    pub iterations: u64,
    /// The largest number of rows of an LCP for the exact solver. It stores a dense column of all unknowns for each
    /// active row, and its time grows with the cube of the number of rows: 0.04 s for the 264 of `chainmail-first`, 3 s
    /// for the 898 of `colony-last` in a release build, and minutes for some thousand.
    pub rows_of_dense: usize,
    /// The largest number of iterations of a solve in a run.
    pub run_iterations: u64,
    /// Steps of the runs that start crowded. The other runs take a multiple of this number.
    pub steps: u64,
}

impl Size {
    /// Some minutes.
    pub const FULL: Size = Size { iterations: 20_000, rows_of_dense: 1_000, run_iterations: 5_000, steps: 5 };
    /// Under a minute: the default solver converges in all measurements, the others in most first solves.
    pub const QUICK: Size = Size { iterations: 1_000, rows_of_dense: 300, run_iterations: 1_000, steps: 1 };
}

/// A stored LCP and its name.
#[derive(Clone, Debug)]
pub struct Named {
    /// Its name in tables.
    pub name: String,
    /// The LCP.
    pub lcp: Stored,
}

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_bytes!(concat!("../../../../assets/lcps/", $name, ".npz")))),*]
    };
}

/// LCPs of runs of this program: `assets/lcps/README.md` describes how each was made.
const BUILT_IN: &[(&str, &[u8])] = built_in![
    "colony-first",
    "colony-last",
    "compaction-first",
    "compaction-last",
    "chainmail-first",
    "chainmail-last",
    "packing-first",
    "packing-last",
];

/// Returns the built-in LCPs: the first and the last one of a step of four runs.
///
/// # Errors
/// [`LcpFileError`]; tests check that it does not occur.
pub fn built_in() -> Result<Vec<Named>, LcpFileError> {
    BUILT_IN.iter().map(|(name, bytes)| Ok(Named { name: (*name).into(), lcp: decode_lcp(bytes)?.0 })).collect()
}

/// Returns the compared solvers with their names: all solvers that a scene may name.
pub fn solvers() -> Vec<(String, SolverKind)> {
    SolverKind::NAMED.map(|(name, kind)| (name.to_owned(), kind)).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_lcps_are_solved_where_they_are_stored() {
        let all = built_in().unwrap();
        assert_eq!(all.len(), BUILT_IN.len());
        for Named { name, lcp } in &all {
            let size = lcp.velocity.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
            assert!(lcp.residual(&lcp.gamma) < 1e-9, "{name}");
            assert!(lcp.residual(&lcp.start) > 1e-6 && lcp.start.iter().any(|x| *x > 0.0), "{name}");
            assert!(lcp.bodies >= 100 && lcp.q.len() > lcp.bodies && size > 0.0, "{name}");
        }
        // The first LCP of a step has one row per pair, the last has more.
        let extra = |lcp: &Stored| {
            let mut pairs = lcp.pair.clone();
            pairs.sort_unstable();
            pairs.dedup();
            lcp.q.len() - pairs.len()
        };
        for step in all.chunks(2) {
            assert_eq!(extra(&step[0].lcp), 0, "{}", step[0].name);
            assert!(extra(&step[1].lcp) > 0, "{}", step[1].name);
        }
    }

    #[test]
    fn all_solvers_but_auto_are_compared() {
        let names: Vec<String> = solvers().into_iter().map(|(name, _)| name).collect();
        for name in ["projected_jacobi", "projected_gauss_seidel", "apgd", "bbpgd", "pair_block_cg", "dense"] {
            assert!(names.iter().any(|n| n == name), "{names:?}");
        }
        assert!(!names.contains(&"auto".to_string()));
    }
}
