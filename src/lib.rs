//! relcp: smooth rigid bodies that do not overlap.
pub mod backend;
pub mod bodies;
pub mod broad_phase;
pub mod cli;
pub mod constraint;
pub mod dynamics;
pub mod freedom;
pub mod lcp;
pub mod record;
pub mod relcp;
pub mod render;
pub mod scene;
pub mod separation;
pub mod shape;
