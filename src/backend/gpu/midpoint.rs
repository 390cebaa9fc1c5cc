//! The parts of a step on the device: a step of first order has one, a midpoint step its first half and then the whole
//! step with what is found in its middle. Forces, mobilities and first rows are those of where a part begins, `here`;
//! moves are from the step's start.
//!
//! In the middle the device has a state more than the start and the trial, and where bodies grow the lengths there
//! beside those at the step's end.

use super::rows::{RowInputs, Rows};
use super::source::{self, Kernels, MidpointKernels, VIOLATING};
use super::states::{Poses, Shapes};
use super::{Device, Setup, words};
use crate::dynamics::Load;
use crate::gpu::{GpuError, Kernel, Recorder};
use crate::step::Fault;
use bytemuck::pod_read_unaligned;

/// What of a step is being computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// All of it, from its start.
    Whole,
    /// Its first half.
    FirstHalf,
    /// All of it, with forces, mobilities and first rows of its middle.
    FromMiddle,
}

impl Setup {
    /// The parameters of kernels that need the length of a part of the step: it and its root after four words.
    pub(super) fn timed(&self, of_kernel: [u32; 4], interval: f64) -> Vec<u8> {
        let mut bytes = words(of_kernel).to_vec();
        bytes.extend(self.precision.encode([interval, interval.sqrt()]));
        bytes
    }

    /// The parameters of a kernel that compares two bodies: with the periods behind them where these change.
    pub(super) fn of_pairs(&self, parameters: &[u8]) -> Vec<u8> {
        match self.strain {
            Some(_) => self.lattice_periods.after(parameters),
            None => parameters.to_vec(),
        }
    }

    /// The same with the periods where the present part begins.
    pub(super) fn of_pairs_here(&self, parameters: &[u8]) -> Vec<u8> {
        match self.strain {
            Some(_) => self.periods_here.after(parameters),
            None => parameters.to_vec(),
        }
    }

    /// The part that a step begins with.
    pub(super) fn first_part(&self) -> Part {
        if self.midpoint { Part::FirstHalf } else { Part::Whole }
    }

    /// The length of a part.
    pub(super) fn length_of(&self, part: Part) -> f64 {
        if part == Part::FirstHalf { 0.5 * self.dt } else { self.dt }
    }
}

impl Device {
    /// Where the step starts.
    pub(super) fn start(&self) -> &Poses {
        self.states.start()
    }

    /// What the bodies are at the end of the present part.
    pub(super) fn start_shapes(&self) -> &Shapes {
        self.states.end_shapes()
    }

    /// Where the present part begins: the middle where it is made, else the start.
    pub(super) fn here(&self) -> &Poses {
        self.states.here(self.part)
    }

    /// What the bodies are in the first rows of the present part.
    pub(super) fn here_shapes(&self) -> &Shapes {
        self.states.here_shapes(self.part)
    }

    /// The parameters of kernels of the present part.
    pub(super) fn timed(&self, of_kernel: [u32; 4]) -> Vec<u8> {
        self.setup.timed(of_kernel, self.setup.length_of(self.part))
    }

    /// When the present part begins and ends.
    fn span(&self) -> [f64; 2] {
        let begin = self.step_start();
        [begin, begin + self.setup.length_of(self.part)]
    }

    /// The parameters of the kernel of motions: those of the present part, and the shares of windows in it.
    fn motion_parameters(&self, parameters: &[u8]) -> Vec<u8> {
        let span = self.span();
        let rates = self.setup.strained().map(|strain| strain.rates(span[0]).to_array());
        let shares = source::loads::windows(&self.setup.forces).into_iter().map(|window| window.share(span));
        [parameters, &self.setup.precision.encode(shares.chain(rates.into_iter().flatten()))].concat()
    }

    /// Forces of a library's user, computed on the host from the state there.
    fn write_loads(&mut self) -> Result<(), Fault> {
        let bodies = self.download(self.here(), self.here_shapes())?;
        let time = self.step_start() + if self.part == Part::FromMiddle { 0.5 * self.setup.dt } else { 0.0 };
        let span = self.span();
        let acting = self.plugged.iter().map(|force| (force, force.share(span)));
        let acting: Vec<_> = acting.filter(|(_, share)| *share > 0.0).collect();
        for (force, _) in &acting {
            force.prepare(&bodies, time).map_err(|what| Fault::Force { step: self.step + 1, what })?;
        }
        let load = |i: usize| {
            let mut load = Load::default();
            for (force, share) in &acting {
                load += *share * force.load(&bodies, i, time);
            }
            let (f, t) = (load.force, load.torque);
            [f.x, f.y, f.z, 0.0, t.x, t.y, t.z, 0.0]
        };
        let loads: Vec<f64> = (0..bodies.len()).flat_map(load).collect();
        self.loads.reserve(&self.gpu, self.bodies)?;
        self.loads.write(&self.gpu, 0, &self.setup.precision.encode(loads));
        Ok(())
    }

    /// Moves walls to where they are at the end of the present part, and in its middle where that is made.
    fn place_walls(&mut self) -> Result<(), GpuError> {
        if !self.setup.walls.move_in_time() {
            return Ok(());
        }
        let ([begin, end], in_middle) = (self.span(), self.part == Part::FromMiddle);
        let Device { gpu, candidates, setup, .. } = self;
        let middle = in_middle.then(|| setup.walls.at(begin + 0.5 * setup.dt));
        candidates.place_walls(gpu, setup, &setup.walls.at(end), middle.as_ref())
    }

    /// Forces, free velocities and mobilities where the present part begins, and the boxes there.
    pub(super) fn set_motion(&mut self) -> Result<(), Fault> {
        if !self.plugged.is_empty() {
            if !std::mem::replace(&mut self.takes_loads, true) {
                self.kernels.motion = Kernel::new(&self.gpu, &source::motion(&self.setup, true))?;
            }
            self.write_loads()?;
        }
        self.write_ids()?;
        self.write_bonds()?;
        self.place_walls()?;
        self.place_cell(self.span())?;
        let (gpu, bodies) = (self.gpu.clone(), self.bodies);
        self.motions.reserve(&gpu, bodies)?;
        self.boxes.reserve(&gpu, bodies)?;
        let mut record = gpu.record();
        record.stage("integrate");
        self.record_heat(&mut record);
        self.record_bonds(&mut record);
        let (here, shapes) = (self.here(), &self.here_shapes().shapes);
        let parameters = self.timed([bodies as u32, u32::from(self.part == Part::FromMiddle), 0, 0]);
        let buffers = [
            ("cells", &here.cells),
            ("remainders", &here.remainders),
            ("orientations", &here.orientations),
            ("shapes", shapes),
            ("twists", &here.twists),
            ("groups_of", &self.groups_of),
            ("loads", &self.loads),
            ("motions", &self.motions),
        ];
        record.run(&self.kernels.motion, &self.motion_parameters(&parameters), &buffers, bodies);
        if let (Part::FromMiddle, Some(MidpointKernels { middle: Some(middle), .. })) =
            (self.part, &self.kernels.midpoint)
        {
            let start = self.start();
            let buffers = [
                ("orientations", &start.orientations),
                ("twists", &start.twists),
                ("shapes", shapes),
                ("motions", &self.motions),
            ];
            record.run(middle, &parameters, &buffers, bodies);
        }
        if let Some(held) = &self.held {
            held.hold(&self.kernels, &mut record, &self.motions);
        }
        self.record_ahead(&mut record);
        let buffers = [
            ("orientations", &self.first().orientations),
            ("shapes", shapes),
            ("motions", &self.motions),
            ("boxes", &self.boxes),
        ];
        record.run(&self.kernels.boxes, &parameters, &buffers, bodies);
        Ok(record.submit()?)
    }

    /// Records the move to `C(U)` over the present part, from the step's start.
    pub(super) fn record_move(&self, record: &mut Recorder<'_>, to: &Poses) {
        let start = self.start();
        let buffers = [
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("orientations", &start.orientations),
            ("velocities", &self.rows.problem.velocity),
            ("motions", &self.motions),
            ("trial_cells", &to.cells),
            ("trial_remainders", &to.remainders),
            ("trial_orientations", &to.orientations),
        ];
        record.run(&self.kernels.trial, &self.timed([self.bodies as u32, 0, 0, 0]), &buffers, self.bodies);
    }

    /// The first half's end as the step's middle, with the velocities there, and the lengths at the step's end.
    pub(super) fn make_middle(&mut self) -> Result<(), Fault> {
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("integrate");
        let middle = self.states.middle();
        self.record_move(&mut record, middle);
        self.record_arrival(&mut record, middle);
        if self.grows() {
            self.states.keep_lengths(&mut record, self.bodies);
            self.record_growth(&mut record);
        }
        record.submit()?;
        self.part = Part::FromMiddle;
        self.set_motion()
    }

    /// The rows, and what they are made from: at the trial, or where first rows are made; and how many there will be.
    pub(super) fn made(&mut self, at_trial: bool) -> (&mut Rows, &Kernels, RowInputs<'_>, u64) {
        let (leads, ahead) = (self.leads(), self.is_ahead() && !at_trial);
        let Device { rows, kernels, candidates, motions, next_rows, setup, part, states, .. } = self;
        let (poses, shapes) = match at_trial {
            true => (&states.trial, states.end_shapes()),
            false => (states.first(*part, leads), states.here_shapes(*part)),
        };
        let made = RowInputs {
            lists: &candidates.lists,
            motions,
            setup,
            part: *part,
            ahead,
            poses,
            shapes,
            grown: states.end_shapes(),
            last: states.start(),
        };
        (rows, kernels, made, *next_rows)
    }

    /// Records the first rows of the present part, for which there is room.
    pub(super) fn record_first_rows(&mut self, record: &mut Recorder<'_>) -> Result<(), GpuError> {
        let gpu = self.gpu.clone();
        self.record_stretch(record);
        let (rows, kernels, made, next_rows) = self.made(false);
        match (made.part, &kernels.midpoint) {
            (Part::FromMiddle, Some(midpoint)) => rows.begin_again(&gpu, kernels, midpoint, record, made, next_rows),
            _ => rows.begin(&gpu, kernels, record, made, next_rows),
        }
    }

    /// Records that separations found in the middle become those with the lengths at the step's end.
    fn record_stretch(&self, record: &mut Recorder<'_>) {
        let Some(MidpointKernels { stretch: Some(stretch), .. }) = &self.kernels.midpoint else { return };
        if self.part != Part::FromMiddle {
            return;
        }
        let lists = &self.candidates.lists;
        let (here, grown) = (self.here_shapes(), self.start_shapes());
        let buffers = [
            ("pairs", &lists.pairs),
            ("orientations", &self.here().orientations),
            ("shapes", &here.shapes),
            ("grown", &grown.shapes),
            ("contacts", &lists.contacts),
        ];
        record.run(stretch, &words([lists.pairs_count as u32, 0, 0, 0]), &buffers, lists.pairs_count);
    }

    /// Moves the offsets of rows to the violations of the trial, and finds room for the rows of those that have none to
    /// be moved.
    pub(super) fn tighten(&mut self) -> Result<(), GpuError> {
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("narrow phase");
        let bodies = self.bodies;
        let (rows, kernels, made, next_rows) = self.made(true);
        let (contacts, pairs) = (&made.lists.contacts, made.lists.pairs_count);
        rows.tighten_branches(&gpu, kernels, &mut record, made, (next_rows, bodies))?;
        if let Some(midpoint) = &kernels.midpoint {
            rows.tighten(midpoint, &mut record, made, bodies);
        }
        rows.count(&gpu, kernels, &mut record, contacts, pairs, (true, VIOLATING))?;
        let read = record.read(&[(&rows.next_start, 4 * pairs..4 * pairs + 4)])?;
        self.next_rows = u64::from(pod_read_unaligned::<u32>(&read[0]));
        Ok(())
    }

    /// Records the velocities that the present part ends with, in the state that it moved `to`.
    pub(super) fn record_arrival(&self, record: &mut Recorder<'_>, to: &Poses) {
        let Some(arrive) = &self.kernels.arrive else {
            record.run(
                &self.kernels.accept,
                &self.parameters(),
                &[("motions", &self.motions), ("twists", &to.twists)],
                self.bodies,
            );
            return;
        };
        let (here, shapes) = (self.here(), &self.here_shapes().shapes);
        let buffers = [
            ("motions", &self.motions),
            ("start_twists", &self.start().twists),
            ("orientations", &here.orientations),
            ("shapes", shapes),
            ("ended", &to.orientations),
            ("twists", &to.twists),
        ];
        let parameters = [self.bodies as u32, u32::from(self.part == Part::FromMiddle), 0, 0];
        let parameters = if self.setup.is_damped() { self.timed(parameters) } else { words(parameters).to_vec() };
        record.run(arrive, &parameters, &buffers, self.bodies);
    }
}
