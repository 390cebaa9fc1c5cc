//! Which cases are taken that are long on a software adapter.

use crate::device::precisions;
use relcp::gpu::{Gpu, Precision};

/// Whether tests take all of their cases, also those that take minutes on a software adapter: `RELCP_LONG_TESTS=1`.
pub fn long_tests() -> bool {
    std::env::var_os("RELCP_LONG_TESTS").is_some()
}

/// The precisions in which long runs are taken whose promise is of no precision, such as to go on with the same bits:
/// the first; all that the device has where long tests are asked for.
pub fn precisions_of_long_runs(gpu: &Gpu) -> Vec<Precision> {
    let mut all = precisions(gpu);
    all.truncate(if long_tests() { all.len() } else { 1 });
    all
}
