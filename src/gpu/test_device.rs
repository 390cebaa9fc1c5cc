//! The one device of a process that runs tests: for this crate's unit tests and for `tests/common/device.rs`.

use super::{Choice, Gpu, Precision};
use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// The number of skipped tests.
static SKIPPED: AtomicUsize = AtomicUsize::new(0);

/// The device. Without a device it prints a line and returns `None`, or fails if `RELCP_REQUIRE_GPU` is set.
pub(crate) fn test_device() -> Option<&'static Arc<Gpu>> {
    static DEVICE: OnceLock<Result<Arc<Gpu>, String>> = OnceLock::new();
    let name = std::env::var("RELCP_ADAPTER").ok();
    let open =
        || Gpu::open(&Choice { name, software: true, ..Choice::default() }).map(Arc::new).map_err(|e| e.to_string());
    match DEVICE.get_or_init(open) {
        Ok(gpu) => Some(gpu),
        Err(why) if std::env::var_os("RELCP_REQUIRE_GPU").is_some() => panic!("a GPU is required: {why}"),
        Err(why) => {
            let test = std::thread::current().name().unwrap_or("a test").to_owned();
            let skipped = SKIPPED.fetch_add(1, Ordering::Relaxed) + 1;
            // The test harness does not capture this, so that skipped tests can be counted.
            let _ = writeln!(std::io::stderr(), "SKIP {skipped}: {test}: {why}");
            None
        }
    }
}

/// The precisions that the device supports; with `RELCP_PRECISION=f32` or `f64` only that one.
pub(crate) fn precisions(gpu: &Gpu) -> Vec<Precision> {
    let mut all = vec![Precision::F32];
    all.extend(gpu.has_f64().then_some(Precision::F64));
    if let Ok(name) = std::env::var("RELCP_PRECISION") {
        all.retain(|precision| precision.name() == name);
        assert!(!all.is_empty(), "RELCP_PRECISION={name}: the device has no such precision");
    }
    all
}
