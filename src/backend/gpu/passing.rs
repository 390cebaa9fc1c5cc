//! Bodies that pass each other: a kernel says how far any surface moves. Where that is far enough, others say whether
//! any two move so far against each other, and only where they do the host looks at the step's way.

use super::Device;
use super::separations::Report;
use crate::dynamics::Twist;
use crate::gpu::GpuError;
use crate::separation::separate_in;
use crate::step::{DEEPER, Passed, may_pass, passed};
use glam::DVec3;

impl Device {
    pub(super) fn passed_on_the_way(&self) -> Result<Option<Passed>, GpuError> {
        if !may_pass(self.farthest, self.setup.thinnest) || !self.some_may_pass()? {
            return Ok(None);
        }
        let mut start = self.download(self.start(), self.start_shapes())?;
        let twist = self.trial_twists()?;
        let separate = separate_in(self.setup.planar);
        // The state before the step has the periods of then, and that of the trial those of its end.
        start.periods = self.setup.strain.map_or(start.periods, |strain| strain.periods(self.step_start()));
        Ok(passed(&start, &twist, (self.setup.dt, self.setup.shear()), |a, b| separate(a, b, None)))
    }

    /// Whether two bodies may have passed: a candidate pair that moves far enough against each other, or any other two
    /// where bodies leave their stored boxes on the way.
    ///
    /// Stored boxes hold the bodies at the trial, and those of two bodies that are no candidate pair are disjoint. A
    /// body starts outside its box by at most `strayed`, and by its turn comes outside by at most `turned` more. Two
    /// such bodies overlap by at most twice the sum, which must reach `DEEPER` of a thickness.
    fn some_may_pass(&self) -> Result<bool, GpuError> {
        let (gpu, bodies) = (self.gpu.clone(), self.bodies);
        let (start, lists, stored) = (self.start(), &self.candidates.lists, &self.candidates.stored);
        // In a cell that changes bodies go with it first, and leave their boxes from there.
        let from = if self.setup.strain.is_some() { self.first() } else { start };
        let mut record = gpu.record();
        record.stage("narrow phase");
        // Nothing has written these words since the report was made blank.
        let buffers = [
            ("cells", &from.cells),
            ("remainders", &from.remainders),
            ("orientations", &from.orientations),
            ("shapes", &self.start_shapes().shapes),
            ("stored_cells", &stored[0]),
            ("stored_remainders", &stored[1]),
            ("stored_boxes", &stored[2]),
            ("report", &self.report),
        ];
        record.run(&self.kernels.stray, &self.parameters(), &buffers, bodies);
        let buffers = [
            ("pairs", &lists.pairs),
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("shapes", &self.start_shapes().shapes),
            ("motions", &self.motions),
            ("report", &self.report),
        ];
        let parameters = self.timed([lists.body_pairs as u32, 0, 0, 0]);
        record.run(&self.kernels.passing, &self.setup.of_pairs_here(&parameters), &buffers, lists.body_pairs);
        let read = record.read(&[(&self.report, 0..Report::BYTES)])?;
        let report: Report = bytemuck::pod_read_unaligned(&read[0]);
        let left = f64::from(f32::from_bits(report.strayed)) + self.turned;
        // What is not a number may be anything.
        let inside = 2.0 * left < DEEPER * self.setup.thinnest;
        Ok(report.passing > 0 || !inside)
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
