//! Growth and division on the device. Who divides and by which random turns is settled on the host, from lengths that
//! are prescribed and so known without asking the device; what moves and turns the daughters is a kernel. Only where
//! pressure slows growth is the state read back for it, each step.

use super::ancestry::Ancestry;
use super::unrounded::split_length;
use super::{Device, Setup, words};
use crate::dynamics::Cells;
use crate::dynamics::growth::Turn;
use crate::gpu::{Buffer, Gpu, GpuError, Recorder};

/// What the kernels of growth read that the host writes. The buffers are kept: new ones would make the device bind all
/// its kernels anew.
pub(super) struct GrowthBuffers {
    /// What each body grows by in a part of a step, as a part of its length.
    growths: Buffer,
    /// The divisions of a step.
    divisions: Buffer,
    indices: Buffer,
}

impl GrowthBuffers {
    pub fn new(gpu: &Gpu, setup: &Setup, ancestry: &mut Ancestry) -> Result<Self, GpuError> {
        let real = setup.precision.bytes();
        let mut made = GrowthBuffers {
            growths: Buffer::new(gpu, "growths", real, ancestry.growing.len() as u64)?,
            divisions: Buffer::new(gpu, "divisions", 12 * real, 0)?,
            indices: Buffer::new(gpu, "dividing bodies", 8, 0)?,
        };
        made.write_changed(gpu, setup, ancestry)?;
        Ok(made)
    }

    /// Writes what bodies grow by whose rates have changed.
    pub fn write_changed(&mut self, gpu: &Gpu, setup: &Setup, ancestry: &mut Ancestry) -> Result<(), GpuError> {
        let lost = self.growths.reserve(gpu, ancestry.growing.len() as u64)?;
        let real = setup.precision.bytes() as u64;
        for (first, growths) in ancestry.changed_growths(lost) {
            self.growths.write(gpu, first as u64 * real, &setup.precision.encode(growths));
        }
        Ok(())
    }
}

impl Device {
    /// The step's start: the accepted state with divided and grown bodies.
    pub(super) fn grow(&mut self) -> Result<(), GpuError> {
        if !self.grows() {
            return Ok(());
        }
        // A step that failed may have left its own start behind.
        self.ancestry.undo();
        let pressures = self.press()?;
        let due = self.ancestry.due().to_vec();
        let old = self.accepted_bodies;
        let bodies = old + due.len() as u64;
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("growth");
        self.states.reserve(&gpu, &mut record, bodies)?;
        self.states.begin(&mut record, old);
        self.bodies = bodies;
        if !due.is_empty() {
            self.divide(&mut record, &due, &pressures)?;
        }
        self.growth.write_changed(&gpu, &self.setup, &mut self.ancestry)?;
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
            &[("shapes", &shapes.shapes), ("lengths", &shapes.lengths), ("growths", &self.growth.growths)],
            self.bodies,
        );
    }

    /// The pressures that slow growth, where the cells feel them, and the rates under them: computed on the host, from
    /// the state that is read back.
    fn press(&mut self) -> Result<Vec<f64>, GpuError> {
        let Some(cells) = self.setup.growth.clone().filter(Cells::feels_pressure) else { return Ok(Vec::new()) };
        let state = self.known_state()?;
        let pressures = cells.pressures(&state.bodies, &state.warm);
        self.ancestry.press(&cells, &pressures);
        Ok(pressures)
    }

    fn divide(&mut self, record: &mut Recorder<'_>, due: &[usize], pressures: &[f64]) -> Result<(), GpuError> {
        let (Some(cells), Some(kernels)) = (&self.setup.growth, &self.kernels.growth) else { return Ok(()) };
        let time = self.step_start();
        let (planar, precision) = (self.setup.planar, self.setup.precision);
        let mut numbers = Vec::with_capacity(12 * due.len());
        let mut indices: Vec<[u32; 2]> = Vec::with_capacity(due.len());
        let old = self.ancestry.group.len();
        for &mother in due {
            let Some(species) = cells.of(self.ancestry.group[mother]) else { continue };
            let degrees = species.growth.reorientation_degrees;
            let mut random = Turn::stream(cells.seed, self.ancestry.lineage[mother].id);
            let turns = [(); 2].map(|()| Turn::draw(&mut random, degrees, planar));
            let pressure = pressures.get(mother).copied().unwrap_or(0.0);
            let (mother, upper, half) = self.ancestry.divide(&species, mother, time, pressure);
            let [coarse, fine] = split_length(half, self.setup.length_pitch);
            numbers.extend([coarse, fine, 0.0, 0.0]);
            numbers.extend(turns.iter().flat_map(|turn| turn.in_body(planar).to_array()));
            indices.push([mother as u32, upper as u32]);
        }
        let gpu = &self.gpu;
        let count = due.len() as u64;
        self.growth.divisions.reserve(gpu, count)?;
        self.growth.divisions.write(gpu, 0, &precision.encode(numbers));
        self.growth.indices.reserve(gpu, count)?;
        self.growth.indices.write(gpu, 0, bytemuck::cast_slice(&indices));
        let lost = self.groups_of.reserve(gpu, self.ancestry.group.len() as u64)?;
        let from = if lost { 0 } else { old };
        self.groups_of.write(gpu, 4 * from as u64, bytemuck::cast_slice(&self.ancestry.group[from..]));
        let (start, shapes) = (self.start(), self.start_shapes());
        let buffers = [
            ("divisions", &self.growth.divisions),
            ("indices", &self.growth.indices),
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("orientations", &start.orientations),
            ("shapes", &shapes.shapes),
            ("lengths", &shapes.lengths),
            ("twists", &start.twists),
        ];
        record.run(&kernels.divide, &words([count as u32, 0, 0, 0]), &buffers, count);
        Ok(())
    }
}
