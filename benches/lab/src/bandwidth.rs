//! How fast a device copies: the floor under everything that moves data.

use relcp::gpu::{Gpu, GpuError, Precision};
use relcp::internals::gpu::{Buffer, Kernel, Source};
use std::time::Instant;

/// Bytes copied at once: more than any cache, and within the binding that every adapter allows.
const BYTES: u64 = 64 << 20;

/// Copies timed together, so that submitting them does not count.
const COPIES: u32 = 16;

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

/// Bytes read and written a second by a kernel that copies.
///
/// # Errors
/// What the device refuses.
pub fn copy_bandwidth(gpu: &Gpu) -> Result<f64, GpuError> {
    let kernel = Kernel::new(gpu, &Source::new("copy", Precision::F32).text(COPY))?;
    let [from, to] = [Buffer::new(gpu, "copied", 16, BYTES / 16)?, Buffer::new(gpu, "copy", 16, BYTES / 16)?];
    let run = |copies: u32| {
        let mut record = gpu.record();
        for _ in 0..copies {
            record.run(&kernel, &[], &[("from_here", &from), ("to_there", &to)], BYTES / 16);
        }
        record.submit()?;
        gpu.wait()
    };
    run(2)?;
    let begun = Instant::now();
    run(COPIES)?;
    Ok(2.0 * f64::from(COPIES) * BYTES as f64 / begun.elapsed().as_secs_f64())
}
