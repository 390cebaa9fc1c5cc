//! Tests of a device before its use: whether kernels run, and how long a loop may be.
//!
//! Mesa's lavapipe before version 23 ends an invocation silently after 65,535 rounds of its loops. Every kernel here
//! stays far below that limit in every scene in which no body has more than some thousands of neighbours, so such a
//! driver is accepted with a warning.

use super::{Buffer, Gpu, GpuError, Kernel, Precision, Source, fragment};

/// Rounds of the tested loop.
const ROUNDS: u32 = 70_000;

pub(super) fn run(gpu: &Gpu) -> Result<Vec<String>, GpuError> {
    let source = Source::with_workgroup("self-test", Precision::F32, 32)
        .integer("ROUNDS", ROUNDS)
        .include(fragment!("common/self_test.wgsl"));
    let kernel = Kernel::new(gpu, &source)?;
    let out = Buffer::new(gpu, "self-test", 4, 64)?;
    let mut record = gpu.record();
    record.run(&kernel, &[], &[&out], 32);
    let read = record.read(&[(&out, 0..256)])?;
    let words: Vec<u32> = read[0].as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect();
    if (0..32).any(|i| words[2 * i] != 1000 * i as u32 + 7) {
        return Err(GpuError::SelfTest { adapter: gpu.name().into(), test: "of arithmetic" });
    }
    let mut warnings = Vec::new();
    if (0..32).any(|i| words[2 * i + 1] != ROUNDS) {
        warnings.push(format!(
            "{} ({}) ends loops after 65,535 rounds (Mesa before 23 does); bodies with more than some thousands of neighbours would be computed wrongly",
            gpu.name(),
            gpu.driver()
        ));
    }
    Ok(warnings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Choice, validate};

    #[test]
    fn literals_take_the_number_type() {
        for precision in [Precision::F32, Precision::F64] {
            let source = Source::new("literals", precision).real("THIRD", 1.0 / 3.0).vector("UP", [0.0, 0.0, 1.0]).text(
                "@group(0) @binding(0) var<storage, read_write> out: array<real>;
                 fn half(v: vec3r) -> real { return 0.5 * dot(v, vec3r(1.0, 0.0, 2.5e-8)) + sqrt(abs(v.x)) / 3; }
                 @compute @workgroup_size(WORKGROUP)
                 fn main(@builtin(local_invocation_index) i: u32) {
                     out[i] = max(half(UP * THIRD), real(i)) + select(real(0.0), real(1.0), i > 3u) - clamp(out[i], -1.0, 1.0) + length(cross(UP, vec3r(THIRD)));
                 }",
            );
            validate(&source).unwrap_or_else(|e| panic!("{e}"));
        }
    }

    #[test]
    fn opens() {
        match Gpu::open(&Choice { software: true, ..Choice::default() }) {
            Ok(gpu) => println!("{} {} {:?} f64 {}", gpu.name(), gpu.driver(), gpu.warnings(), gpu.has_f64()),
            Err(e) => println!("{e}"),
        }
    }
}
