//! Pictures of bodies: those that the library draws, `relcp render` and `relcp view`.
#![allow(clippy::unwrap_used)]

#[path = "../common/program.rs"]
mod program;
mod render;
mod render_command;
mod view_command;
