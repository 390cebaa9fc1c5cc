//! The LCP on the device.
//!
//! The solvers are those of the CPU, written over [`Verbs`](super::verbs::Verbs). Here the verbs write a tape of
//! instructions, which is divided into stages and executed some iterations at a time. The device tests convergence, and
//! the host reads a few residuals per batch.

mod clusters;
mod elements;
mod friction;
mod friction_kernels;
mod kernels;
mod layout;
mod machine;
mod memory;
mod number;
mod problem;
mod room;
mod run;
mod shape;
mod solver;
mod stage;
mod straight;
mod tape;

#[cfg(test)]
mod tests;
mod text;
mod turns;
mod verbs;

pub use friction::FrictionSolver;
pub use problem::DeviceProblem;
pub use solver::Solver;
