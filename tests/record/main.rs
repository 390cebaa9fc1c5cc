//! What a run leaves in its folder, and runs that are taken up again from it.
#![allow(clippy::unwrap_used)]

mod branch;
mod changes;
mod killed;
mod lcps;
mod runs;
