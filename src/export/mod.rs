//! The states of a run in formats that other programs read: GSD for OVITO and HOOMD's tools, VTK's for ParaView,
//! LAMMPS' text dump and extended XYZ for OVITO, ASE and scripts.
//!
//! [`States`] finds the states, [`gsd()`], [`vtk()`], [`lammps()`] and [`xyz()`] write them. Each file is written
//! atomically. Shapes are exact wherever the format supports them: see the modules of these names for the layout, and
//! for the form of rods, rings and superellipsoids.
//!
//! ```
//! use relcp::export::{Format, export};
//! use relcp::record::States;
//! let folder = tempfile::tempdir()?;
//! let states = States::open("three-capsules")?;
//! let done = export(&states, Format::Vtk { cutoff: None }, folder.path(), &mut |_done, _all| true)?;
//! assert!(done.files.contains(&folder.path().join("bodies.pvd")));
//! # Ok::<(), relcp::Error>(())
//! ```

mod classes;
mod error;
mod file_layer;
pub mod gsd;
pub mod lammps;
mod surface;
mod text;
pub mod vtk;
mod vtp;
pub mod xyz;

pub use error::ExportError;
pub use gsd::gsd;
pub use lammps::lammps;
pub use vtk::{SCRIPT, vtk};
pub use xyz::xyz;

use crate::record::{RecordError, States, Watch};
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};

/// The exponents of an ellipsoid, for columns that all bodies have.
const ELLIPSOID: [f64; 2] = [2.0; 2];

/// A format.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Format {
    /// One GSD file.
    Gsd,
    /// One LAMMPS text dump.
    Lammps,
    /// One extended XYZ file.
    Xyz,
    /// ParaView's collections and the files in them.
    Vtk {
        /// Pairs nearer than this are contacts; see [`contacts`](crate::record::contacts).
        cutoff: Option<f64>,
    },
}

/// The result of an export.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exported {
    /// The files, the one to open first.
    pub files: Vec<PathBuf>,
    /// States written.
    pub states: usize,
    /// The largest number of bodies in a state.
    pub bodies: usize,
    /// The total number of bytes.
    pub bytes: u64,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Writes states in a format into a folder, which is created if necessary. Files of an earlier export are replaced.
///
/// # Errors
/// Those of [`fn@gsd`], [`fn@vtk`], [`fn@lammps`] and [`fn@xyz`]; a folder that cannot be created.
pub fn export(states: &States, format: Format, folder: &Path, watch: Watch) -> Result<Exported, ExportError> {
    fs::create_dir_all(folder).map_err(RecordError::io(folder, "create the folder"))?;
    match format {
        Format::Gsd => gsd(states, &folder.join(format!("{}.gsd", states.name())), watch),
        Format::Lammps => lammps(states, &folder.join(format!("{}.lammpstrj", states.name())), watch),
        Format::Xyz => xyz(states, &folder.join(format!("{}.xyz", states.name())), watch),
        Format::Vtk { cutoff } => vtk(states, folder, cutoff, watch),
    }
}
