//! The linear complementarity problem of one solve, `0 <= g(gamma) = q + A gamma  _|_  gamma >= 0`, and its solvers.
//! Where rows have friction the multipliers of a contact lie in a cone, those of bonds are free (`friction`).
//!
//! `A = J J^T` is never formed: `J` has one sparse row per constraint, with one block per body of its pair. The rows
//! are already scaled by the factor of the effective mobility (see `constraint`), so a solver knows nothing of laws or
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
mod friction;
#[cfg(feature = "mpi")]
pub(crate) mod gathered;
mod interior_point;
mod islands;
mod kind;
mod local;
mod multifrontal;
mod numbering;
mod on_rows;
mod pair_block_cg;
mod passes;
mod places;
mod portion;
mod projected_gauss_seidel;
mod projected_jacobi;
mod relax;
mod solver;
mod sparse_cholesky;
mod stored;
mod taken;
mod team;

pub use drive::ResidualSample;
pub use friction::Cone;
#[cfg(feature = "gpu")]
pub(crate) use friction::packed::PackedContacts;
pub use kind::SolverKind;
pub(crate) use places::Places;
pub(crate) use portion::{Alone, Portion};
pub use solver::Solver;
pub use stored::Stored;

/// An LCP. `g` and `q` are lengths; `D` is the number of unknowns of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Problem<const D: usize> {
    /// The number of bodies that rows refer to.
    pub bodies: usize,
    /// The two bodies of each row, distinct. Several rows may have the same pair, in any order.
    pub pair: Vec<[u32; 2]>,
    /// The two blocks of each row of `J`.
    pub jacobian: Vec<[[f64; D]; 2]>,
    /// `g` at `gamma = 0`.
    pub q: Vec<f64>,
    /// What the multiplier of each row may be; empty if all rows are alone.
    pub cones: Vec<Cone>,
    /// What is added to the diagonal of `A`, a length over a force a row: the elastic slip of tangents, what a bond
    /// gives. Empty for nothing, and where `cones` is.
    pub compliance: Vec<f64>,
}

impl<const D: usize> Problem<D> {
    /// `q + J v` of a row, with contact velocities `v`.
    pub(crate) fn value(&self, row: usize, v: &[[f64; D]]) -> f64 {
        let ([a, b], [ja, jb]) = (self.pair[row], &self.jacobian[row]);
        let dot = |j: &[f64; D], v: &[f64; D]| j.iter().zip(v).map(|(j, v)| j * v).sum::<f64>();
        self.q[row] + dot(ja, &v[a as usize]) + dot(jb, &v[b as usize])
    }
}

/// When a solver stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Largest natural residual `max |min(g, s gamma)|` that counts as solved, a length.
    pub tolerance: f64,
    /// The limit on iterations.
    pub max_iterations: u64,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The residual is at or under the tolerance.
    Solved,
    /// The iteration limit was reached; the best iterate is returned.
    MaxIterations,
    /// The residual stopped improving; the best iterate is returned.
    NoProgress,
    /// Rounding keeps the residual above the tolerance: gradients updated by recurrence meet it repeatedly, and
    /// recomputed ones do not. The best iterate is returned.
    RoundingFloor,
    /// No velocity of ordinary size satisfies all rows, and the solver has proven it; the best iterate is returned.
    Infeasible,
    /// Contradictory rows were violated as little as possible; the residual is the violation ([`Solver::relax`]).
    LeastOverlap,
    /// The law of friction was not met to the tolerance; it was solved with its corrections held, so that gaps of what
    /// slides are off ([`Solver::relax`]). The residual is that of the problem with the corrections held.
    HeldFriction,
    /// Nor was it met with its corrections held, and normal rows have a common solution: this one, without friction
    /// ([`Solver::relax`]). The residual is the largest violation of a normal row.
    WithoutFriction,
    /// The factor of the matrix would exceed its size limit; the start is returned.
    TooLarge,
    /// A number was not finite; the best iterate before it is returned.
    NotFinite,
}

impl Status {
    /// The name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Status::Solved => "solved",
            Status::MaxIterations => "max_iterations",
            Status::NoProgress => "no_progress",
            Status::RoundingFloor => "rounding_floor",
            Status::Infeasible => "infeasible",
            Status::LeastOverlap => "least_overlap",
            Status::HeldFriction => "held_friction",
            Status::WithoutFriction => "without_friction",
            Status::TooLarge => "too_large",
            Status::NotFinite => "not_finite",
        }
    }
}

/// The outcome of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Outcome {
    /// How it ended.
    pub status: Status,
    /// Iterations taken.
    pub iterations: u64,
    /// Applications of `A`; an application of `J^T` or `J` counts as half.
    pub products: u64,
    /// Factorizations of sparse matrices.
    pub factorizations: u64,
    /// Whether [`auto`](SolverKind::Auto) fell back to the interior-point method.
    pub fallback: bool,
    /// Natural residual of the returned `gamma`, a length.
    pub residual: f64,
}

/// `J^T gamma`, the contact velocity of every body in the scaled unknowns.
///
/// # Panics
/// If a row refers to a body out of range.
pub fn velocity<const D: usize>(problem: &Problem<D>, gamma: &[f64]) -> Vec<[f64; D]> {
    let mut out = Vec::new();
    velocity_into(problem, gamma, &mut out);
    out
}

/// [`velocity`] into an existing vector.
///
/// # Panics
/// If a row refers to a body out of range.
pub fn velocity_into<const D: usize>(problem: &Problem<D>, gamma: &[f64], out: &mut Vec<[f64; D]>) {
    out.resize(problem.bodies, [0.0; D]);
    product::scatter(&problem.pair, &problem.jacobian, gamma, out);
}
