//! What a study was computed on, in words.

/// The program, how it was built, and the machine.
pub(super) fn machine() -> String {
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
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
