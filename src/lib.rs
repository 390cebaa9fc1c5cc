//! Smooth rigid bodies that do not overlap: spheres, rods, ellipsoids and rings in contact, by a recursively generated
//! linear complementarity problem (ReLCP; Palmer, Aktulga, Gao: "Smooth-Rigid-Body Contact as a ReLCP", 2026).
//!
//! # The equations
//!
//! A step of `dt` starts at the configuration `C^k` and moves every body with one constant generalized velocity `U =
//! (u, w)`:
//!
//! ```text
//! C(U):  x = x^k + dt u,   q = normalize(q^k + dt/2 (0, w) (x) q^k)
//! U    = U_free + E D gamma                         E: effective mobility, D: transposed rows
//! 0 <= g(U) = Phi(C_j) + dt D . (U - U_j)  _|_  gamma >= 0      one row a constraint, made at C_j = C(U_j)
//! A    = dt D^T E D = J J^T,   q_row = g(U_free)
//! ```
//!
//! Without inertia `U_free = M F` and `E = M`. With it `U_free` is the velocity that the step would move with without
//! contact, `E = dt M^-1`, and the state ends with the velocity of its momenta, which are kept ([`dynamics`]).
//!
//! The first rows are made at `C^k` (`U_j = 0`), in the plane a quarter of a step ahead of it, one for each smooth
//! branch of a near pair's separation ([`separation::branches`]). After a solve, all pairs are tested in the trial
//! `C(U)`. Each that overlaps by more than the tolerance gets one more row, made there, or in the plane has its own row
//! moved. The new problem is solved again, until none overlaps.
//!
//! # Symbols
//!
//! | symbol | in code | meaning | unit |
//! | --- | --- | --- | --- |
//! | `Phi` | `separation` | shared-normal signed distance of a pair; negative where it overlaps | length |
//! | `n` | `normal` | unit normal from a to b | 1 |
//! | `r_a`, `r_b` | `lever_a`, `lever_b` | from a centre to its contact point | length |
//! | `D` | row | `(-n, -r_a x n, n, r_b x n)`, carried back to `C^k` (`constraint`) | 1, length |
//! | `gamma` | `gamma` | the contact force of a row | force |
//! | `g` | | a row's linearised separation | length |
//! | `E`, `L` | [`dynamics::Factor`] | effective mobility and its symmetric root | |
//! | `U` | [`motion::Twist`] | generalized velocity of a body | length / time, 1 / time |
//! | `tau` | `solver.tolerance` | largest natural residual `max abs min(g, A_ii gamma)` of a solved LCP | length |
//! | `eps` | `contact.overlap_tolerance` | largest overlap of an accepted step | length |
//!
//! # A first run
//!
//! ```
//! use relcp::{Simulation, scene};
//! let scene = Scene::built_in("three-capsules")?;
//! let mut simulation = Simulation::new(scene)?;
//! let report = simulation.step()?;
//! assert!(report.max_overlap < 1e-5 && report.recursions == 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The step itself is [`step::step`], over the verbs of [`step::Backend`].

mod backend;
#[cfg(feature = "files")]
pub mod batch;
pub mod bodies;
mod broad_phase;
mod constraint;
pub mod dynamics;
mod error;
#[cfg(feature = "files")]
pub mod export;
mod freedom;
pub mod gpu;
#[doc(hidden)]
pub mod internals;
pub mod lcp;
#[cfg(feature = "files")]
pub mod measure;
pub mod motion;
pub mod periodic;
#[cfg(feature = "python")]
pub mod python;
#[cfg(feature = "files")]
pub mod record;
#[cfg(feature = "files")]
pub mod render;
#[cfg(feature = "files")]
pub mod run;
pub mod scene;
pub mod separation;
pub mod shape;
pub mod simulation;
pub mod step;
#[cfg(feature = "studies")]
#[doc(hidden)]
pub mod study;
#[cfg(feature = "files")]
pub mod view;
pub mod walls;
pub mod warm;

pub use bodies::Bodies;
pub use dynamics::{ForceField, Load};
pub use error::Error;
pub use glam;
pub use scene::{Scene, SceneError};
pub use separation::{Placed, Separation};
pub use shape::Shape;
pub use simulation::{Compute, Simulation, SimulationBuilder};
pub use step::{Contact, Fault, State, StepReport, contacts};
pub use walls::WallContact;

/// The README's example compiles and runs with the others.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
