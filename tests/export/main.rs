//! Exports are read back: by small readers of the two formats here, and by the real ones where Python has them.
//!
//! `RELCP_PYTHON` names a Python with `gsd` and `vtk` (and, if it is there, `ovito`); without it that test prints
//! `SKIP`.
#![allow(clippy::unwrap_used)]

mod bonds;
mod command;
mod gsd;
mod gsd_file;
#[path = "../common/program.rs"]
mod program;
mod readers;
mod scenes;
mod superellipsoids;
mod text_files;
mod vtk;
mod vtp_file;
