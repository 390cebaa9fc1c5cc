//! Bodies that pass each other: a kernel says how far any surface moves, and only where that is far enough the host
//! looks at the step's way.

use super::Device;
use crate::dynamics::Twist;
use crate::gpu::GpuError;
use crate::separation::{planar_separation, separation};
use crate::step::{Passed, may_pass, passed};
use glam::DVec3;

impl Device {
    pub(super) fn passed_on_the_way(&self) -> Result<Option<Passed>, GpuError> {
        let thinnest = self.setup.shapes.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min);
        if !may_pass(self.farthest, thinnest) {
            return Ok(None);
        }
        let start = self.download(self.start(), self.start_shapes(), self.bodies, &self.ancestry)?;
        let twist = self.trial_twists()?;
        let separate = if self.setup.planar { planar_separation } else { separation };
        Ok(passed(&start, &twist, self.setup.dt, |a, b| separate(a, b, None)))
    }

    /// The velocities that lead from the start to the trial.
    fn trial_twists(&self) -> Result<Vec<Twist>, GpuError> {
        let bytes = self.bodies * self.motions.element() as u64;
        let read = self.gpu.record().read(&[(&self.motions, 0..bytes)])?;
        let numbers = self.setup.precision.decode(&read[0]);
        let width = 4 * self.setup.motion_width() as usize;
        let twist = |motion: &[f64]| Twist {
            linear: DVec3::new(motion[8], motion[9], motion[10]),
            angular: DVec3::new(motion[12], motion[13], motion[14]),
        };
        Ok(numbers.chunks_exact(width).map(twist).collect())
    }
}
