//! The method as a whole: rows against finite differences, the paper's cases against independent figures, and what the
//! theory promises.
#![allow(clippy::unwrap_used)]

mod colonies;
mod failing;
mod first_violation;
mod growth;
mod hard_cases;
mod inertia;
mod laws;
mod midpoint;
mod paper_scenes;
mod passing;
mod promises;
mod random;
mod rows;
mod solvers_agree;
mod three_capsules;
mod two_ellipsoids;
mod two_sided;
mod wall_rows;
mod wall_steps;
mod walls;
