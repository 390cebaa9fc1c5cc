//! Custom shapes: what is measured of them, what is refused, separations, walls and steps.

#![allow(clippy::unwrap_used)]

mod bodies;
#[path = "../common/directions.rs"]
mod directions;
mod refusals;
mod separation;
mod shape;
mod steps;
mod superellipsoids;
mod walls;
