//! The one device of the test process.

#[path = "../../src/gpu/test_device.rs"]
mod test_device;

use relcp::gpu::{Choice, Gpu, Precision};
#[allow(unused_imports)]
pub(crate) use test_device::{precisions, test_device as device};

#[test]
fn opens_and_says_what_it_is() {
    let Some(gpu) = device() else { return };
    assert!(!gpu.name().is_empty());
    gpu.wait().unwrap();
}
