//! Many runs from one file: the members of a sweep, their folders, and the table of their results.
//!
//! A [`Sweep`] is one scene in many variants. A [`Plan`] is a sweep with every member's scene read and validated;
//! [`run`] runs the members, several at a time, each in its own folder, which is identified by the hash of its scene.
//! Finished members are left alone, and stopped ones continue from their checkpoints. A [`Table`] is made from the
//! folders.
//!
//! ```
//! use relcp::batch::Plan;
//! let sweep = r#"{ "name": "steps", "scene": "three-capsules", "grid": { "time.dt": [0.1, 0.05] }, "seeds": [1, 2] }"#;
//! let plan = Plan::parse(sweep, "sweep.json", std::path::Path::new("."))?;
//! assert_eq!(plan.columns(), ["time.dt", "seed"]);
//! assert_eq!(plan.members()[2].label(), "time.dt=0.05, seed=1");
//! assert_eq!(plan.scene(2)?.time.dt, 0.05);
//! # Ok::<(), relcp::batch::BatchError>(())
//! ```

mod error;
mod member_state;
mod members;
mod ordered;
mod plan;
mod run;
mod sweep;
mod table;

pub use error::{BatchError, MemberError};
pub use member_state::{Folders, MemberState, Outcome, Products, Recursions, Wall};
pub use ordered::Ordered;
pub use plan::{Member, Plan};
pub use run::{Ended, Options, Settle, Watch, run};
pub use sweep::{MAX_MEMBERS, SeedRow, Seeds, Sweep, schema};
pub use table::{Row, RowStatus, Table};
