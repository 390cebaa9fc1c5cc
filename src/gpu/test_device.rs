//! The one device of the process that runs this crate's unit tests.

use super::{Choice, Gpu, Precision};
use std::io::Write;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many tests were skipped.
static SKIPPED: AtomicUsize = AtomicUsize::new(0);

/// The device, or `None` after a line that says so; without one it fails where `RELCP_REQUIRE_GPU` is set.
pub(crate) fn test_device() -> Option<&'static Gpu> {
    static DEVICE: OnceLock<Result<Gpu, String>> = OnceLock::new();
    let name = std::env::var("RELCP_ADAPTER").ok();
    let open = || Gpu::open(&Choice { name, software: true, ..Choice::default() }).map_err(|e| e.to_string());
    match DEVICE.get_or_init(open) {
        Ok(gpu) => Some(gpu),
        Err(why) if std::env::var_os("RELCP_REQUIRE_GPU").is_some() => panic!("a GPU is required: {why}"),
        Err(why) => {
            let test = std::thread::current().name().unwrap_or("a test").to_owned();
            let skipped = SKIPPED.fetch_add(1, Ordering::Relaxed) + 1;
            let _ = writeln!(std::io::stderr(), "SKIP {skipped}: {test}: {why}");
            None
        }
    }
}

/// The precisions that the device has.
pub(crate) fn precisions(gpu: &Gpu) -> Vec<Precision> {
    if gpu.has_f64() { vec![Precision::F32, Precision::F64] } else { vec![Precision::F32] }
}
