//! A description of the machine of a study, and processor time.

use cpu_time::ProcessTime;
use std::time::{Duration, Instant};

/// Describes the program, its build and the machine.
pub fn machine() -> String {
    let build =
        if cfg!(debug_assertions) { "a build with debug assertions, so times are long" } else { "a release build" };
    format!(
        "Program {}, {build}, {} threads, {} ({}), {}",
        env!("CARGO_PKG_VERSION"),
        rayon::current_num_threads(),
        processor().unwrap_or_else(|| "a processor that does not say its name".into()),
        std::env::consts::ARCH,
        std::env::consts::OS
    )
}

/// Returns the processor's name, if Linux provides it.
pub(super) fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// The beginning of a measurement, in wall time and processor time.
pub(super) struct Begun {
    clock: Instant,
    processor: Option<ProcessTime>,
}

/// The duration of a measurement.
pub(super) struct Took {
    /// Wall time.
    pub wall: Duration,
    /// Processor time of all threads of this process; wall time if the system does not provide it.
    pub processor: Duration,
}

impl Begun {
    pub fn now() -> Self {
        Begun { clock: Instant::now(), processor: ProcessTime::try_now().ok() }
    }

    pub fn elapsed(&self) -> Took {
        let wall = self.clock.elapsed();
        let processor = self.processor.and_then(|begun| begun.try_elapsed().ok()).unwrap_or(wall);
        Took { wall, processor }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Work that takes a processor at least a second.
    const ROUNDS: u64 = 1_000_000_000;

    #[test]
    fn the_processors_time_goes_on_while_it_works() {
        assert!(ProcessTime::try_now().is_ok());
        let begun = Begun::now();
        let mut sum = 0u64;
        for round in 0..ROUNDS {
            sum = std::hint::black_box(sum ^ round);
            if round % 1_000_000 == 0 && !begun.elapsed().processor.is_zero() {
                return;
            }
        }
        panic!("no time passed in {ROUNDS} rounds");
    }
}
