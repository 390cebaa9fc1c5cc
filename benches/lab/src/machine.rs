//! What a study was computed on, in words, and the processor's time.

use cpu_time::ProcessTime;
use std::time::{Duration, Instant};

/// The program, how it was built, and the machine.
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

/// The processor's name, where Linux tells it.
pub(super) fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// When something began, by the clock and by the processor.
pub(super) struct Begun {
    clock: Instant,
    processor: Option<ProcessTime>,
}

/// How long it took.
pub(super) struct Took {
    /// By the clock.
    pub wall: Duration,
    /// Of the processor, by all threads of this process; the clock's time where the system does not tell it.
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

    /// Work that takes a processor a second or more.
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
