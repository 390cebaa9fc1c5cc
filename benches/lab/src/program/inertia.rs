//! `relcp-lab inertia`: conservation in inertial motion.

use super::arguments::Arguments;
use super::fault::LabError;
use super::paper::{made, size};
use super::study::{Found, computes, write_all};
use relcp::gpu::Precision;
use relcp::simulation::Compute;
use relcp_lab::inertia::{Size, Study};

pub fn inertia(arguments: &Arguments) -> Result<Found, LabError> {
    // Before the first measurement, so that an unwritable folder is reported at once.
    write_all(&arguments.out, [])?;
    let mut all = computes(arguments)?;
    // A requested device is measured in both precisions, if it supports both.
    if let Some(Compute::Gpu { gpu, precision }) = all.last().cloned() {
        let other = if precision == Precision::F32 { Precision::F64 } else { Precision::F32 };
        all.extend(gpu.check(other).is_ok().then_some(Compute::Gpu { gpu, precision: other }));
    }
    made(Study::begin(size(arguments, Size::QUICK, Size::FULL), all), arguments)
}
