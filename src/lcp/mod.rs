//! The linear complementarity problem of one solve, `0 <= g(gamma) = q + A gamma  _|_  gamma >= 0`, and its solvers.
//!
//! `A = J J^T` is never formed: `J` has one sparse row a constraint, with one block a body of its pair. The rows are
//! already scaled by the factor of the effective mobility (see `constraint`), so a solver knows nothing of laws or
//! shapes, and `v = J^T gamma` is the contact velocity in those scaled unknowns.

pub(crate) mod clusters;
pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod incidence;
mod loops;
pub(crate) mod pair_blocks;
pub(crate) mod product;
pub(crate) mod verbs;

mod apgd;
mod auto;
mod bbpgd;
mod cluster_cg;
mod cone;
mod dense;
#[cfg(feature = "mpi")]
pub(crate) mod domain;
mod drive;
mod engine;
#[cfg(feature = "mpi")]
pub(crate) mod gathered;
mod interior_point;
mod kind;
mod local;
mod numbering;
mod on_rows;
mod pair_block_cg;
mod places;
mod portion;
mod projected_gauss_seidel;
mod projected_jacobi;
mod relax;
mod solver;
mod stored;
mod team;

pub use drive::ResidualSample;
pub use kind::SolverKind;
pub(crate) use places::Places;
pub(crate) use portion::{Alone, Portion};
pub use solver::Solver;
pub use stored::Stored;

/// One LCP. `g`, `q` are lengths; `D` is the number of unknowns of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Problem<const D: usize> {
    /// How many bodies the rows refer to.
    pub bodies: usize,
    /// The two bodies of each row, distinct. Several rows may have the same pair, in any place.
    pub pair: Vec<[u32; 2]>,
    /// The two blocks of each row of `J`.
    pub jacobian: Vec<[[f64; D]; 2]>,
    /// `g` at `gamma = 0`.
    pub q: Vec<f64>,
}

/// When a solver stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Largest natural residual `max |min(g, s gamma)|` that counts as solved, a length.
    pub tolerance: f64,
    /// Most iterations.
    pub max_iterations: u64,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The residual is at or under the tolerance.
    Solved,
    /// The iterations were used up; the best iterate is returned.
    MaxIterations,
    /// No iterate improved on the best one for long; the best iterate is returned.
    NoProgress,
    /// Rounding keeps the residual above the tolerance: gradients kept by recurrence come to it again and again, and
    /// fresh ones show that they are wrong. The best iterate is returned.
    RoundingFloor,
    /// No velocity of ordinary size satisfies all rows: proven, by a solver that can; the best iterate is returned.
    Infeasible,
    /// Rows that contradict each other were violated as little as can be: the residual says by how much
    /// ([`Solver::relax`]).
    LeastOverlap,
    /// The factor that the solver needs would be over its bound; the start is returned.
    TooLarge,
    /// A number that is not finite turned up; the best iterate before it is returned.
    NotFinite,
}

impl Status {
    /// As files and tables say it.
    pub fn name(self) -> &'static str {
        match self {
            Status::Solved => "solved",
            Status::MaxIterations => "max_iterations",
            Status::NoProgress => "no_progress",
            Status::RoundingFloor => "rounding_floor",
            Status::Infeasible => "infeasible",
            Status::LeastOverlap => "least_overlap",
            Status::TooLarge => "too_large",
            Status::NotFinite => "not_finite",
        }
    }
}

/// What a solve did.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Outcome {
    /// How it ended.
    pub status: Status,
    /// Iterations taken.
    pub iterations: u64,
    /// Applications of `A`; two of a half of it, `J^T x` or `J v`, count as one.
    pub products: u64,
    /// Factorizations of sparse matrices.
    pub factorizations: u64,
    /// Whether [`auto`](SolverKind::Auto) went on with the interior-point method.
    pub fallback: bool,
    /// Natural residual of the returned `gamma`, a length.
    pub residual: f64,
}

/// `J^T gamma`, the contact velocity of every body in the scaled unknowns.
///
/// # Panics
/// If a row names a body that is not there.
pub fn velocity<const D: usize>(problem: &Problem<D>, gamma: &[f64]) -> Vec<[f64; D]> {
    let mut out = Vec::new();
    velocity_into(problem, gamma, &mut out);
    out
}

/// [`velocity`] into a vector that is there already.
///
/// # Panics
/// If a row names a body that is not there.
pub fn velocity_into<const D: usize>(problem: &Problem<D>, gamma: &[f64], out: &mut Vec<[f64; D]>) {
    out.resize(problem.bodies, [0.0; D]);
    product::scatter(&problem.pair, &problem.jacobian, gamma, out);
}
