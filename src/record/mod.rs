//! A run's folder and the states in it: what is written, so that it is there whole or not at all, and read back.
//!
//! [`Run`] steps a simulation and leaves its [`Folder`]: `scene.json`, `steps.csv`, `states/state_NNNNNNNNNN.npz`,
//! `checkpoint.npz` and the one before it, `final.json`, `final.png` and `summary.json`, and `measures.csv` and `lcps/` where the scene asks for them. States are
//! [one container](encode) that numpy opens as `.npz`.
//!
//! ```
//! use relcp::record::{COLUMNS, Folder};
//! let parent = tempfile::tempdir()?;
//! let folder = Folder::create_in(parent.path(), "two rods")?;
//! assert!(folder.path().ends_with("two-rods"));
//! assert!(folder.state(12).ends_with("states/state_0000000012.npz"));
//! assert_eq!(COLUMNS[0], "step");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod blocks;
mod container;
mod difference;
pub(crate) mod durable;
mod error;
mod folder;
mod hash;
mod lcp_file;
mod measured;
mod memory;
mod npz;
mod rows;
mod run;
mod schedule;
mod steps;
mod summary;
#[cfg(test)]
mod tests;
mod totals;

pub use container::{FORMAT, Header, VERSION, decode, encode, encode_with_forces, read_state, write_state};
pub(crate) use difference::differing_keys;
pub use error::{RecordError, RunError, StateError};
pub use folder::Folder;
pub(crate) use folder::folder_name;
pub(crate) use hash::Fnv;
pub use hash::{scene_hash, state_hash};
pub use lcp_file::{LCP_FORMAT, LCP_VERSION, LcpFileError, LcpHeader, decode_lcp, encode_lcp, read_lcp, write_lcp};
pub use memory::peak_bytes;
pub use run::{CHECKPOINT_EVERY, Run};
pub use steps::{COLUMNS, StepRow};
pub use summary::{Constraints, PeakBytes, Recursions, RunStatus, SolverSummary, Summary};
pub use totals::{OverStep, PassedStep, Retried, Totals, UnconvergedStep, UnsettledStep, WallSeconds};
