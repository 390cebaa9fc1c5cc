//! The peak memory of the process.

/// The peak memory of the process so far, in bytes; `None` if the system does not report it (`VmHWM` in
/// `/proc/self/status`, as Linux does).
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
