//! The copy bandwidth of a device: a lower bound on the time of everything that moves data.

use relcp::gpu::{Gpu, GpuError, Precision};
use relcp::internals::gpu::{Buffer, Kernel, Source};
use std::time::Instant;

/// Bytes per copy on a software adapter: more than any cache, and within the binding limit of every adapter.
const BYTES_ON_SOFTWARE: u64 = 64 << 20;

/// The same on hardware, where a copy must take longer than its submission: on an NVIDIA H200, 64 MiB take 30 us by
/// bandwidth, but 100 us were measured.
const BYTES: u64 = 512 << 20;

/// Copies that are timed together, so that their submission does not count.
const COPIES: u32 = 16;

/// Number of measurements. The fastest counts.
const ROUNDS: usize = 3;

const COPY: &str = "
@group(0) @binding(0) var<storage, read> from_here: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> to_there: array<vec4<f32>>;
@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i < arrayLength(&from_here) { to_there[i] = from_here[i]; }
}
";

/// Returns the bytes per second that a copy kernel reads and writes.
///
/// # Errors
/// Errors of the device.
pub fn copy_bandwidth(gpu: &Gpu) -> Result<f64, GpuError> {
    let kernel = Kernel::new(gpu, &Source::new("copy", Precision::F32).text(COPY))?;
    let bytes = if gpu.is_software() { BYTES_ON_SOFTWARE } else { BYTES };
    let [from, to] = [Buffer::new(gpu, "copied", 16, bytes / 16)?, Buffer::new(gpu, "copy", 16, bytes / 16)?];
    let run = |copies: u32| {
        let mut record = gpu.record();
        for _ in 0..copies {
            record.run(&kernel, &[], &[&from, &to], bytes / 16);
        }
        record.submit()?;
        gpu.wait()
    };
    run(2)?;
    let mut fastest = f64::INFINITY;
    for _ in 0..ROUNDS {
        let begun = Instant::now();
        run(COPIES)?;
        fastest = fastest.min(begun.elapsed().as_secs_f64());
    }
    Ok(2.0 * f64::from(COPIES) * bytes as f64 / fastest)
}
