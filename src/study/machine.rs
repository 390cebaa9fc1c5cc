//! What a study was computed on, in words, and the processor's time.

use std::time::Duration;

/// Ticks of the processor's time in a second, as Linux shows them to programs on every architecture that this one runs on.
const TICKS: f64 = 100.0;

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

/// The processor's time that this process has taken so far, of all its threads, to a hundredth of a second; where Linux tells it.
pub(super) fn cpu_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The program's name, in parentheses, may hold anything; the first field after it is the third.
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let ticks: u64 = fields.next()?.parse::<u64>().ok()? + fields.next()?.parse::<u64>().ok()?;
    Some(Duration::from_secs_f64(ticks as f64 / TICKS))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// Work that takes a processor a second or more; a hundredth of one is seen.
    const ROUNDS: u64 = 1_000_000_000;

    #[test]
    fn the_processors_time_goes_on_while_it_works() {
        let before = cpu_time().unwrap();
        let mut sum = 0u64;
        for round in 0..ROUNDS {
            sum = std::hint::black_box(sum ^ round);
            if round % 1_000_000 == 0 && cpu_time().unwrap() > before {
                return;
            }
        }
        panic!("no time passed in {ROUNDS} rounds");
    }
}
