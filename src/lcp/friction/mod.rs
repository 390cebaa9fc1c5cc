//! Problems over friction cones, solved for the exact law: Signorini's condition and isotropic Coulomb friction.
//!
//! A contact has a normal row and one or two tangent rows (one in the plane), with multipliers `(gamma_n, gamma_t)`, a
//! gap `g` and a slip `s`, all gaps and slips being `q + (A + k) gamma` with a compliance `k` of tangents:
//!
//! ```text
//! K = { |gamma_t| <= mu gamma_n },   K* = { g >= mu |s| }
//! K contains gamma  _|_  (g + mu |s|, s) in K*
//! ```
//!
//! That is `g >= 0`, `gamma_n >= 0`, `g gamma_n = 0`, `|gamma_t| <= mu gamma_n`, and `gamma_t = -mu gamma_n s / |s|`
//! where something slips. De Saxce's correction `mu |s|` makes it one complementarity condition; without it the law is
//! the convex relaxation of Anitescu and Tasora, which opens a gap `mu |s|` under what slides.
//!
//! With the correction as an offset `e` that is held, the problem is the optimality condition of a convex one, and the
//! method of conjugate gradients and the accelerated gradients ([`super::pair_block_cg`], [`super::apgd`]) solve it as
//! they are, with projections on `K` in place of those on `gamma >= 0` (`rows`, `pairs`, `block`, `cone`). `e` follows
//! the slips within the running solve (`follow`, `drive`), whose directions are kept. The residual is that of the exact
//! law, a length:
//!
//! ```text
//! max | S gamma - P_K( S gamma - (g + mu |s|, s) ) | over cones,   max | min(g, S gamma) | over rows alone
//! ```
//!
//! with `S` the mean diagonal entry of the unit's block and `P_K` the projection.
//!
//! A free row ([`Cone::Free`]), a bond, is an equation `q + (A + k) gamma = 0`: it has no projection, and its residual
//! is `|g|`. Those of bonds that resist turns are eliminated together (`linked`).
//!
//! The law need not have one solution where nothing gives way: rigid contacts at rest share friction in many ways, and
//! even the velocities may differ between starts. A start and a solver give the same bits each time.
//!
//! Sources: G. De Saxce, Z.-Q. Feng, The bipotential method, 1998; V. Acary, F. Cadoux, C. Lemarechal, J. Malick, A
//! formulation of the linear discrete Coulomb friction problem via convex optimization, 2011 (fixed point on `e`); V.
//! Acary, M. Bremond, O. Huber, On solving contact problems with Coulomb friction: formulations and numerical
//! comparisons, 2018; A. Tasora, M. Anitescu, A matrix-free cone complementarity approach for solving large-scale,
//! nonsmooth, rigid body dynamics, 2011; H. Mazhar, T. Heyn, D. Negrut, A. Tasora, Using Nesterov's method to
//! accelerate multibody dynamics with friction and contact, 2015.
//!
//! Measurements are in docs/notes/friction-solver.md.

mod block;
mod cone;
mod drive;
mod follow;
mod interior;
mod linked;
mod pace;
#[cfg(feature = "gpu")]
pub(super) mod packed;
mod pairs;
mod problem;
mod rows;
mod scalars;
#[cfg(test)]
pub(super) mod tests;
mod unit;

/// The constants that kernels share.
#[cfg(feature = "gpu")]
pub(super) mod constants {
    pub(in crate::lcp) use super::block::{CONVERGED, MOST_ROUNDS, MOST_SWEEPS, NEGLIGIBLE};
    pub(in crate::lcp) use super::cone::{ON_BOUNDARY, ROUNDING};
    pub(in crate::lcp) use super::follow::{GROWTH, SMALLEST};
    pub(in crate::lcp) use super::pairs::{SETTLED, SWEEPS};
}

pub(super) use drive::Friction;
#[cfg(feature = "gpu")]
pub(super) use drive::ITERATIONS_TO_HALVE;
#[cfg(feature = "gpu")]
pub(super) use pace::{Measured, PACE_OF_PAIRS, Pace};
pub use problem::Cone;
use problem::tangents;
#[cfg(all(test, feature = "gpu"))]
pub(super) use rows::Frictional;
