//! The files of a run's folder and its states: written atomically, and read back.
//!
//! A [run](crate::run) writes its [`Folder`]: `scene.json`, `steps.csv`, `states/state_NNNNNNNNNN.npz`,
//! `checkpoint.npz` and the one before it, `final.json`, `final.png` and `summary.json`, and `measures.csv`,
//! `lineage.csv` and `lcps/` if the scene requests them. `from.json` names the state of another run that it began with.
//! States are [one container](encode) that numpy opens as `.npz`.
//!
//! ```
//! use relcp::record::{COLUMNS, Folder};
//! let parent = tempfile::tempdir()?;
//! let folder = Folder::create_in(parent.path(), "two rods")?;
//! assert!(folder.path().ends_with("two-rods"));
//! assert!(folder.state(12).ends_with("states/state_0000000012.npz"));
//! assert_eq!(COLUMNS[0], "step");
//! # Ok::<(), relcp::Error>(())
//! ```

mod blocks;
mod contacts;
mod container;
mod difference;
#[doc(hidden)]
pub mod durable;
mod earlier;
mod error;
pub(crate) mod fnv;
mod folder;
mod hash;
mod held;
mod lcp_file;
mod leg;
pub(crate) mod lives;
mod npz;
mod parent;
pub(crate) mod rows;
mod states;
pub(crate) mod steps;
mod table;
#[cfg(test)]
mod tests;
mod totals;

pub use contacts::{ContactForce, TOUCHING, contacts};
pub use container::{
    FORMAT, FieldHeader, Header, VERSION, decode, encode, encode_with_forces, read_state, write_state,
};
pub use difference::{all_differing_keys, differing_keys};
pub use earlier::{EarlierRun, EarlierState};
pub use error::{LcpFileError, RecordError, StateError, StatesError};
pub(crate) use fnv::Fnv;
pub use folder::Folder;
pub(crate) use folder::folder_name;
pub use hash::{scene_hash, state_hash};
pub use lcp_file::{LCP_FORMAT, LCP_VERSION, LcpHeader, decode_lcp, encode_lcp, read_lcp, write_lcp};
pub use leg::Leg;
pub use lives::LifeRow;
pub use parent::Parent;
pub(crate) use states::scene_of;
pub use states::{Snapshot, States, Watch};
pub use steps::{COLUMNS, StepRow};
pub use table::{Table, TableColumn};
pub use totals::{OverStep, PassedStep, Retried, Totals, UnconvergedStep, UnsettledStep, WallSeconds};
