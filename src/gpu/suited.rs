//! Which precision suits a device: f64 where its kernels are not much slower than those of f32. Adapters that compute
//! on a processor are not measured: processors have units for f64.

use super::{Buffer, Gpu, GpuError, Kernel, Precision, Source};
use std::time::Instant;

/// f64 suits a device whose arithmetic takes at most so many times as long in f64. By their data sheets devices for
/// computing take 2 times as long and devices for pictures 32 or 64; lavapipe takes 0.9 to 1.1 times as long
/// (measured, which takes it a second). So the choice does not hang on the noise of a measurement.
const MOST: f64 = 8.0;

/// Invocations, of which each does `ROUNDS` multiplications and additions that wait for each other.
const INVOCATIONS: u64 = 1 << 16;
const ROUNDS: u32 = 2048;

/// Runs of each precision by turns, of which the shortest counts.
const RUNS: u32 = 3;

const TEXT: &str = "
@group(0) @binding(0) var<storage, read_write> numbers: array<real>;
@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    var x = numbers[i];
    for (var round = 0u; round < ROUNDS; round += 1u) {
        x = x * numbers[0] + numbers[1];
    }
    numbers[i] = x;
}
";

/// The precision that a device computes in where none is asked for.
///
/// # Errors
/// What the device refuses.
pub(crate) fn suited(gpu: &Gpu) -> Result<Precision, GpuError> {
    if !gpu.has_f64() {
        return Ok(Precision::F32);
    }
    if gpu.is_software() {
        return Ok(Precision::F64);
    }
    let ratio = time_of_f64(gpu)?;
    log::debug!("{}: arithmetic in f64 takes {ratio:.1} times as long as in f32", gpu.name());
    Ok(if ratio <= MOST { Precision::F64 } else { Precision::F32 })
}

/// How many times as long arithmetic takes in f64 as in f32.
fn time_of_f64(gpu: &Gpu) -> Result<f64, GpuError> {
    let of = |precision: Precision| {
        let source = Source::new("arithmetic", precision).integer("ROUNDS", ROUNDS).text(TEXT);
        let numbers = Buffer::new(gpu, "arithmetic", precision.bytes(), INVOCATIONS)?;
        Ok((Kernel::new(gpu, &source)?, numbers))
    };
    let both = [of(Precision::F32)?, of(Precision::F64)?];
    let mut shortest = [f64::INFINITY; 2];
    // The first run is not timed.
    for run in 0..=RUNS {
        for ((kernel, numbers), shortest) in both.iter().zip(&mut shortest) {
            let begun = Instant::now();
            let mut record = gpu.record();
            record.run(kernel, &[], &[("numbers", numbers)], INVOCATIONS);
            record.submit()?;
            gpu.wait()?;
            if run > 0 {
                *shortest = shortest.min(begun.elapsed().as_secs_f64());
            }
        }
    }
    Ok(shortest[1] / shortest[0].max(f64::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::test_device;

    #[test]
    fn a_device_with_f64_is_measured_and_one_without_takes_f32() {
        let Some(gpu) = test_device() else { return };
        let suited = suited(gpu).unwrap();
        println!("{}: {}", gpu.name(), suited.name());
        assert!(gpu.has_f64() || suited == Precision::F32);
        if gpu.has_f64() {
            let ratio = time_of_f64(gpu).unwrap();
            println!("{ratio:.2} times as long");
            assert!(ratio.is_finite() && ratio > 0.0);
        }
    }
}
