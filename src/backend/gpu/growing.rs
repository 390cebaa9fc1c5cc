//! Growth and division on the device. Who divides and by which random turns is settled on the host, from lengths that
//! are prescribed and so known without asking the device; what moves and turns the daughters is a kernel. Only where
//! pressure slows growth is the state read back for it, each step.

use super::state::split_length;
use super::{Ancestry, Device, Setup, words};
use crate::dynamics::growth::{Turn, daughters};
use crate::gpu::{Buffer, Gpu, GpuError, Recorder};

impl Device {
    /// The step's start: the accepted state with divided and grown bodies.
    pub(super) fn grow(&mut self) -> Result<(), GpuError> {
        if !self.grows() {
            return Ok(());
        }
        // A step that failed may have left its own start behind.
        if let Some(before) = self.before.take() {
            self.ancestry = before;
            self.write_growths()?;
        }
        let pressures = self.press()?;
        let old = self.accepted_bodies;
        let Ancestry { length, division, .. } = &self.ancestry;
        let due: Vec<usize> = (0..old as usize).filter(|i| length[*i] >= division[*i]).collect();
        let bodies = old + due.len() as u64;
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("growth");
        for poses in &mut self.poses {
            poses.reserve(&gpu, &mut record, bodies)?;
        }
        for shapes in &mut self.shapes {
            shapes.reserve(&gpu, &mut record, bodies)?;
        }
        self.start().copy_from(&mut record, &self.poses[0], old);
        self.start_shapes().copy_from(&mut record, &self.shapes[0], old);
        self.bodies = bodies;
        if !due.is_empty() {
            self.divide(&mut record, &due, &pressures)?;
        }
        self.record_growth(&mut record);
        record.submit()
    }

    /// Records what the bodies grow by in a part of the step.
    pub(super) fn record_growth(&self, record: &mut Recorder<'_>) {
        let Some(growth) = &self.kernels.growth else { return };
        let shapes = self.start_shapes();
        record.run(
            &growth.grow,
            &self.parameters(),
            &[("shapes", &shapes.shapes), ("lengths", &shapes.lengths), ("growths", &self.growths)],
            self.bodies,
        );
    }

    /// The growing lengths after an accepted step.
    pub(super) fn lengthen(&mut self) {
        let (interval, Ancestry { length, rate, .. }) = (growing_interval(&self.setup), &mut self.ancestry);
        // Part by part, as on the CPU to the last bit: that says who divides.
        for _ in 0..if self.setup.midpoint { 2 } else { 1 } {
            length.iter_mut().zip(&*rate).for_each(|(length, rate)| *length *= (*rate * interval).exp());
        }
    }

    /// What each body grows by, after divisions or without them.
    fn write_growths(&mut self) -> Result<(), GpuError> {
        self.growths = growths(&self.gpu, &self.setup, &self.ancestry)?;
        Ok(())
    }

    /// The pressures that slow growth, where the cells feel them, and the rates under them: computed on the host, from
    /// the state that is read back.
    fn press(&mut self) -> Result<Vec<f64>, GpuError> {
        let Some(cells) = self.setup.growth.filter(|cells| cells.growth.stress_sensitivity > 0.0) else {
            return Ok(Vec::new());
        };
        let state = self.known_state()?;
        let pressures = cells.pressures(&state.bodies, &state.warm);
        let Ancestry { rate, lineage, .. } = &mut self.ancestry;
        for ((rate, line), pressure) in rate.iter_mut().zip(lineage).zip(&pressures) {
            *rate = cells.rate(line.id, *pressure);
        }
        self.write_growths()?;
        Ok(pressures)
    }

    fn divide(&mut self, record: &mut Recorder<'_>, due: &[usize], pressures: &[f64]) -> Result<(), GpuError> {
        let (Some(cells), Some(kernels)) = (self.setup.growth, &self.kernels.growth) else { return Ok(()) };
        self.before = Some(self.ancestry.clone());
        let time = self.step_start();
        let (planar, precision) = (self.setup.planar, self.setup.precision);
        let mut numbers = Vec::with_capacity(12 * due.len());
        let mut indices: Vec<[u32; 2]> = Vec::with_capacity(due.len());
        let degrees = cells.growth.reorientation_degrees;
        let ancestry = &mut self.ancestry;
        for &mother in due {
            let upper = ancestry.lineage.len();
            let line = ancestry.lineage[mother];
            let half = 0.5 * ancestry.length[mother];
            let mut random = Turn::stream(cells.seed, line.id);
            let turns = [(); 2].map(|()| Turn::draw(&mut random, degrees, planar));
            let [first, second] = daughters(&line, time, &mut ancestry.next_id);
            ancestry.lineage[mother] = first;
            ancestry.lineage.push(second);
            ancestry.group.push(ancestry.group[mother]);
            ancestry.length[mother] = half;
            ancestry.length.push(half);
            for own in [&mut ancestry.division, &mut ancestry.rate] {
                own.push(0.0);
            }
            for (daughter, id) in [(mother, first.id), (upper, second.id)] {
                ancestry.division[daughter] = cells.division_length(id);
                ancestry.rate[daughter] = cells.rate(id, pressures.get(mother).copied().unwrap_or(0.0));
            }
            let [coarse, fine] = split_length(half, self.setup.length_pitch);
            numbers.extend([coarse, fine, 0.0, 0.0]);
            numbers.extend(turns.iter().flat_map(|turn| turn.in_body(planar).to_array()));
            indices.push([mother as u32, upper as u32]);
        }
        let gpu = &self.gpu;
        let divisions = Buffer::reals(gpu, "divisions", precision, 12, numbers)?;
        let indices = Buffer::with(gpu, "dividing bodies", 8, bytemuck::cast_slice(&indices))?;
        self.groups_of.reserve(gpu, self.ancestry.group.len() as u64)?;
        self.groups_of.write(gpu, 0, bytemuck::cast_slice(&self.ancestry.group));
        let (start, shapes) = (self.start(), self.start_shapes());
        let buffers = [
            ("divisions", &divisions),
            ("indices", &indices),
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("orientations", &start.orientations),
            ("shapes", &shapes.shapes),
            ("lengths", &shapes.lengths),
            ("twists", &start.twists),
        ];
        record.run(&kernels.divide, &words([due.len() as u32, 0, 0, 0]), &buffers, due.len() as u64);
        // The buffers go with this function: the device must have them by then.
        record.submit()?;
        self.write_growths()
    }
}

/// The length of a part of a step, in each of which bodies grow.
fn growing_interval(setup: &Setup) -> f64 {
    setup.length_of(setup.first_part())
}

/// What each body grows by in a part of a step, as a part of its length, on the device.
pub(super) fn growths(gpu: &Gpu, setup: &Setup, ancestry: &Ancestry) -> Result<Buffer, GpuError> {
    let interval = growing_interval(setup);
    let growths = ancestry.rate.iter().map(|rate| (rate * interval).exp_m1());
    Buffer::reals(gpu, "growths", setup.precision, 1, growths)
}
