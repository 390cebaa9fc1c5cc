//! The paper's own tests, measured and set beside its figures (Palmer, Aktulga, Gao: "Smooth-Rigid-Body Contact as a
//! ReLCP", 2026).

mod census;
pub mod chainmail;
pub mod colony;
mod columns;
pub mod compaction;
pub mod jitter;
mod measured;
mod norms;
pub mod packing;
mod summary;
mod target;
pub mod two_ellipsoids;

pub use census::{Census, Count};
pub use measured::Measured;
pub use norms::{Cost, Reached, cost_at, extrapolated, l2, order};
pub use summary::{RunSummary, Window, follow, follow_with, method_name};
pub use target::Target;
pub(super) use target::table as target_table;

/// What these studies are computed by: sub-spheres are not on a device.
pub const COMPUTED_BY: &str = "CPU f64";
