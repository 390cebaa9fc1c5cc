//! What of a step on the device concerns periodic space: that a pair can meet at one image only.

use super::Device;
use super::separations::Report;
use crate::step::Fault;

/// Roundings that half a period is longer by: a body's reach is a radius, half the cutoff and two products, each
/// rounded. Bodies that this lets through may be near at another image than the nearest by as much, but overlap at
/// none: scenes whose bodies are that long are refused on reading.
const ROUNDINGS: f64 = 8.0;

impl Device {
    /// Refuses bodies that reach, or move freely in this step, too far for the shortest period, so that other images
    /// than the nearest could come near. A box's fourth number is the radius, half the cutoff and that way.
    pub(super) fn check_periods(&self, report: &Report) -> Result<(), Fault> {
        let Some(period) = self.setup.periods.shortest() else { return Ok(()) };
        let precision = self.setup.precision;
        let most = 0.5 * period * (1.0 + ROUNDINGS * precision.epsilon());
        // The report has 32 bits.
        let largest = f64::from(f32::from_bits(report.largest)) * (1.0 + f64::from(f32::EPSILON));
        if 2.0 * largest <= most {
            return Ok(());
        }
        let bytes = self.bodies * self.boxes.element() as u64;
        let read = self.gpu.record().read(&[(&self.boxes, 0..bytes)])?;
        let boxes = precision.decode(&read[0]);
        let spans = boxes.as_chunks::<4>().0.iter().map(|[_, _, _, radius]| 2.0 * radius);
        match spans.enumerate().find(|(_, span)| *span > most) {
            Some((body, span)) => Err(Fault::PeriodTooShort { step: self.step + 1, body, span, period }),
            None => Ok(()),
        }
    }
}
