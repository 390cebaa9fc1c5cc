//! A run that begins on the CPU and goes over to a device where the device takes its steps in less time.
//!
//! Which of the two is faster depends on the scene, its size and the machine, so it is measured: `chooser.rs` says when,
//! `leg.rs` records what came of it, `hand_over.rs` moves a simulation's state from one to the other.

mod chooser;
mod hand_over;
mod leg;
mod machines;
mod settings;
#[cfg(test)]
mod tests;
mod trial;

pub use leg::{Leg, Machine, Reason};
pub use settings::Settings;

use super::Compute;
use crate::gpu::{Choice, Gpu, GpuError, Precision};
use chooser::Chooser;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// What tells the time, in seconds from a moment of its own. It is asked while a machine computes, and told which.
pub type Clock = Arc<dyn Fn(Machine) -> f64 + Send + Sync>;

/// A device that takes a simulation over from the CPU where it is faster: see [`Compute::Auto`].
///
/// It is opened when it is tried for the first time. Clones share it.
#[derive(Clone)]
pub struct Automatic {
    choice: Choice,
    precision: Option<Precision>,
    settings: Settings,
    clock: Clock,
    opened: Arc<OnceLock<Result<Arc<Gpu>, GpuError>>>,
}

impl Automatic {
    /// The first device that fits the choice, in this precision, or without one in the precision that suits it.
    pub fn new(choice: Choice, precision: Option<Precision>) -> Self {
        let begun = Instant::now();
        let clock = Arc::new(move |_| begun.elapsed().as_secs_f64());
        Automatic { choice, precision, settings: Settings::default(), clock, opened: Arc::default() }
    }

    /// With other settings and another clock: for tests.
    #[doc(hidden)]
    pub fn with(mut self, settings: Settings, clock: Option<Clock>) -> Self {
        self.settings = settings;
        self.clock = clock.unwrap_or(self.clock);
        self
    }

    /// The device, opened at the first call. Its kernels are compiled when they are made, so that no step that is
    /// measured waits for a compiler.
    fn open(&self) -> Result<Compute, GpuError> {
        let gpu = self.opened.get_or_init(|| {
            let gpu = Gpu::open(&self.choice)?;
            gpu.compile_at_once();
            Ok(Arc::new(gpu))
        });
        Compute::of_device(gpu.clone()?, self.precision)
    }
}

/// A simulation's device and what chooses between it and the CPU.
pub(super) struct Auto {
    automatic: Automatic,
    chooser: Chooser,
}

impl Auto {
    pub(super) fn new(automatic: &Automatic) -> Self {
        Auto { automatic: automatic.clone(), chooser: Chooser::new(automatic.settings) }
    }

    /// Counts what the run took before this simulation took it up.
    #[cfg(feature = "files")]
    pub(super) fn resume(&mut self, seconds: f64, lost: f64) {
        self.chooser.resume(seconds, lost);
    }
}
