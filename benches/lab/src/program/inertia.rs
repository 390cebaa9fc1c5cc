//! `relcp-lab inertia`: what inertial motion keeps.

use super::arguments::Arguments;
use super::fault::LabError;
use super::paper::{made, size};
use super::study::{Found, computes, write_all};
use relcp::gpu::Precision;
use relcp::simulation::Compute;
use relcp_lab::inertia::{Size, Study};

pub fn inertia(arguments: &Arguments) -> Result<Found, LabError> {
    // Before anything is measured, so that a folder that cannot be written to costs nothing.
    write_all(&arguments.out, [])?;
    let mut all = computes(arguments)?;
    // A device that was asked for, in the other precision too where it has both.
    if let Some(Compute::Gpu { gpu, precision }) = all.last().cloned() {
        let other = if precision == Precision::F32 { Precision::F64 } else { Precision::F32 };
        all.extend(gpu.check(other).is_ok().then_some(Compute::Gpu { gpu, precision: other }));
    }
    made(Study::begin(size(arguments, Size::QUICK, Size::FULL), all), arguments)
}
