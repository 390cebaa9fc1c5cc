//! Smooth rigid bodies in contact: spheres, rods, ellipsoids, rings and shapes of your own that do not overlap.
//!
//! After every step the true surfaces overlap by less than a tolerance that you choose. Each step solves a linear
//! complementarity problem for the contact forces, and adds constraints until no pair overlaps: the recursively
//! generated LCP (ReLCP) of Palmer, Aktulga and Gao, "Smooth-Rigid-Body Contact as a ReLCP" (2026).
//!
//! # A first run
//!
//! One cell grows and divides in the plane until there are eight. The scene is made in code, so this runs without any
//! feature of the crate:
//!
//! ```
//! use relcp::scene::{Generate, Growth, Time};
//! use relcp::{Scene, Simulation};
//!
//! fn main() -> Result<(), relcp::Error> {
//!     let mut scene = Scene::new("colony", Time::new(0.01, 2.2)); // steps of 0.01 to time 2.2
//!     scene.planar = true;
//!     scene.growth = vec![Growth::new(1.0, 4.0)]; // length' = length; division at length 4
//!     scene.generate = vec![Generate::founder(0.5, 2.0)];
//!     let mut simulation = Simulation::new(scene)?;
//!     while !simulation.done() {
//!         assert!(simulation.step()?.max_overlap <= 1e-5); // the default tolerance
//!     }
//!     assert_eq!(simulation.state()?.bodies.len(), 8);
//!     Ok(())
//! }
//! ```
//!
//! With the feature `files` (in the default features), scenes are also read: `Scene::built_in("colony")?`, or
//! `Scene::load("mine.json", ["time.dt=0.005"])?`. Units of length, time and force are your own.
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
//! branch of a near pair's separation. After a solve, all pairs are tested in the trial `C(U)`. Each that overlaps by
//! more than the tolerance gets one more row, made there, or in the plane has its own row moved. The new problem is
//! solved again, until none overlaps.
//!
//! # Symbols
//!
//! | symbol | in code | meaning | unit |
//! | --- | --- | --- | --- |
//! | `Phi` | [`Contact::separation`] | shared-normal signed distance of a pair; negative where it overlaps | length |
//! | `n` | [`Contact::normal`] | unit normal from a to b | 1 |
//! | `r_a`, `r_b` | [`Contact::levers`] | from a centre to its contact point | length |
//! | `D` | row | `(-n, -r_a x n, n, r_b x n)`, carried back to `C^k` | 1, length |
//! | `gamma` | `gamma` | the contact force of a row | force |
//! | `g` | | a row's linearised separation | length |
//! | `E` | [`dynamics`] | effective mobility | |
//! | `U` | [`Twist`] | generalized velocity of a body | length / time, 1 / time |
//! | `tau` | `solver.tolerance` | largest natural residual `max abs min(g, A_ii gamma)` of a solved LCP | length |
//! | `eps` | `contact.overlap_tolerance` | largest overlap of an accepted step | length |
//!
//! # Where to go
//!
//! | for | see |
//! | --- | --- |
//! | a scene: bodies, forces, walls, periods, growth, settings | [`Scene`], [`scene`] |
//! | steps, states, what a step reports | [`Simulation`], [`State`], [`StepReport`] |
//! | a simulation from bodies of your own, from a saved state, on a GPU | [`Simulation::builder`], [`Compute`] |
//! | contacts, with normals and points | [`contacts()`], [`Simulation::contacts`] |
//! | forces and shapes of your own | [`ForceField`], [`shape::Convex`] |
//! | separations of two shapes by themselves | [`separation`](mod@separation) |
//! | an LCP by itself | [`lcp`] |
//! | errors | [`Error`], [`Fault`] |
//! | with `files`: a run's folder, pictures, measures, exports, batches | `run`, `record`, `render`, `measure`, `export`, `batch` |
//!
//! The folder `examples` has one short program for each of these, `docs/guide.md` the choice of a step and of
//! tolerances, `docs/limitations.md` what the method does not do.

#[cfg(test)]
mod additions;
mod backend;
#[cfg(feature = "files")]
pub mod batch;
mod bisection;
pub mod bodies;
mod broad_phase;
#[cfg(test)]
mod circles;
mod constraint;
#[doc(hidden)]
pub mod digits;
pub mod dynamics;
mod error;
#[cfg(feature = "files")]
pub mod export;
pub mod fields;
#[cfg(feature = "files")]
pub mod figure;
mod fixed;
mod freedom;
pub mod gpu;
#[doc(hidden)]
pub mod internals;
#[cfg(test)]
mod layers;
pub mod lcp;
#[cfg(feature = "files")]
pub mod measure;
mod motion;
#[cfg(feature = "files")]
mod page;
pub mod periodic;
#[cfg(feature = "mpi")]
pub mod processes;
#[cfg(feature = "cli")]
mod program;
#[cfg(feature = "python")]
pub mod python;
#[cfg(feature = "files")]
pub mod record;
pub mod removal;
#[cfg(feature = "files")]
pub mod render;
#[cfg(feature = "files")]
pub mod run;
pub mod scene;
pub mod separation;
pub mod shape;
pub mod simulation;
pub mod step;
#[cfg(feature = "files")]
pub mod view;
pub mod walls;
pub mod warm;
mod window;

pub use bodies::Bodies;
pub use dynamics::{ForceField, Load};
pub use error::Error;
pub use glam;
pub use motion::Twist;
pub use scene::{Scene, SceneError};
pub use separation::{Placed, Separation};
pub use shape::Shape;
pub use simulation::{Compute, Simulation, SimulationBuilder};
pub use step::{Contact, Fault, State, StepReport, contacts};
pub use walls::WallContact;

/// The README's example compiles and runs with the others.
#[cfg(all(doctest, feature = "files"))]
#[doc = include_str!("../README.md")]
pub struct Readme;
