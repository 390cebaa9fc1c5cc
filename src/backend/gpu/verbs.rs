//! The implementation of the verbs.

use super::Device;
use super::hosted::HostedRows;
use super::narrow_phase::Report;
use super::part::Part;
use super::row_set::RowSet;
use super::start::Stages;
use crate::backend::cpu::hosted::DeviceStart;
use crate::dynamics::Cells;
use crate::freedom::{PLANAR, SPATIAL};
use crate::gpu::GpuError;
use crate::lcp::{Outcome, Status, Stored};
use crate::separation::separate_in;
use crate::step::{Effect, Fault, Overlap, Passed, Phases, Surplus, Take, TwoSided, Verbs, may_pass, passed};
use std::sync::OnceLock;
use std::time::Instant;

impl Device {
    /// The step's start: the accepted state with divided and grown bodies.
    fn grow(&mut self) -> Result<(), GpuError> {
        // A failed step may have left its own start behind.
        self.start.ancestry.undo();
        let slowing = self.slow()?;
        let Device { gpu, setup, states, start, solve, accepted, .. } = self;
        start.grow(gpu, setup, states, (accepted.bodies, &slowing))?;
        solve.compile(gpu, start.bodies)
    }

    /// What slows growth, if pressure or want may, and the growth rates for it. The host computes it from the state
    /// that it reads back.
    fn slow(&mut self) -> Result<Vec<f64>, GpuError> {
        let Some(cells) = self.setup.growth.clone().filter(Cells::may_be_slowed) else { return Ok(Vec::new()) };
        let state = self.known_state()?;
        let slowing = cells.slowing(&state.bodies, &state.warm, &state.fields);
        self.start.ancestry.slow(&cells, &slowing);
        Ok(slowing)
    }

    /// Computes forces, free velocities and mobilities at the beginning of the present part, and the boxes there.
    fn set_motions(&mut self) -> Result<(), Fault> {
        if self.motions.has_plugged() {
            self.write_loads()?;
        }
        let Device { gpu, setup, states, start, motions, first, narrow, .. } = self;
        motions.write(gpu, setup, start)?;
        let candidates = &mut narrow.candidates;
        if setup.walls.move_in_time() {
            let [begin, end] = start.span(setup);
            let middle = (start.part == Part::FromMiddle).then(|| setup.walls.at(begin + 0.5 * setup.dt));
            candidates.place_walls(gpu, setup, &setup.walls.at(end), middle.as_ref())?;
        }
        if let Some(periods) = start.place_cell(setup)? {
            candidates.place_cell(periods);
        }
        motions.reserve(gpu, start.bodies)?;
        let mut record = gpu.record();
        record.stage("integrate");
        let stages = Stages { gpu, setup, states, start };
        motions.record(stages, &mut record);
        first.record(stages, &mut record, motions);
        motions.record_boxes(stages, &mut record, first.poses(stages));
        Ok(record.submit()?)
    }

    /// Tells the host how the step begins, where it has a part in it.
    fn begin_on_host(&mut self) -> Result<(), Fault> {
        if self.hosted.is_none() {
            return Ok(());
        }
        let (stages, start) = (self.stages(), &self.start);
        let mut bodies = self.download(stages.states.start(), stages.states.end_shapes())?;
        // Images are those at the start of the step.
        bodies.periods = self.setup.strain.map_or(bodies.periods, |strain| strain.periods(start.time));
        let (steps, lengthened) = (self.accepted.step, start.ancestry.lengthened());
        let begun = DeviceStart { steps, bodies, lengthened, motion: self.motions.read(stages)? };
        if let Some(hosted) = &mut self.hosted {
            hosted.begin(&self.gpu, begun)?;
        }
        Ok(())
    }

    /// Writes user-defined forces.
    fn write_loads(&mut self) -> Result<(), Fault> {
        self.motions.take_loads(&self.gpu, &self.setup)?;
        let stages = self.stages();
        let bodies = self.download(stages.here(), stages.here_shapes())?;
        self.motions.write_loads(&self.gpu, &self.setup, &self.start, &bodies)
    }

    /// Makes the end of the first half the step's middle, with the velocities there and the lengths at the step's end.
    fn set_middle(&mut self) -> Result<(), Fault> {
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("integrate");
        let (stages, Device { states, motions, rows, trial, .. }) = (self.stages(), &*self);
        trial.record_move(stages, &mut record, (motions, &rows.problem.velocity), states.middle());
        trial.record_arrival(stages, &mut record, motions, states.middle());
        states.keep_lengths(&mut record, stages.start.bodies);
        stages.record_growth(&mut record);
        record.submit()?;
        self.start.part = Part::FromMiddle;
        self.set_motions()
    }

    /// The pairs that tunnelled between the start and the trial.
    fn find_passed(&self) -> Result<Option<Passed>, GpuError> {
        let Device { setup, states, start, motions, first, narrow, trial, passing, .. } = self;
        if !may_pass(trial.farthest(), setup.thinnest) {
            return Ok(None);
        }
        // In a changing cell, the cell first carries the bodies; they leave their boxes from the resulting poses.
        let from = if setup.strain.is_some() { first.poses(self.stages()) } else { states.start() };
        if !passing.some_may_pass(self.stages(), (narrow, motions), from, trial.turned())? {
            return Ok(None);
        }
        let mut bodies = self.download(states.start(), states.end_shapes())?;
        let twists = motions.trial_twists(self.stages())?;
        let separate = separate_in(setup.planar);
        let but = self.hosted.as_ref().map_or(&[][..], HostedRows::without_contact);
        // The state before the step has the periods of its time, and the trial has those at the end.
        bodies.periods = setup.strain.map_or(bodies.periods, |strain| strain.periods(start.time));
        Ok(passed(&bodies, &twists, (setup.dt, setup.shear()), but, |a, b| separate(a, b, None)))
    }
}

impl Verbs for Device {
    fn begin(&mut self) -> Result<(), Fault> {
        self.gpu.begin_step();
        self.start.begin(&self.setup, self.accepted.step);
        self.first.ahead = self.setup.leads_ahead();
        let begun = Instant::now();
        if self.setup.growth.is_some() {
            self.grow()?;
            self.phases.growth += begun.elapsed();
        }
        let begun = Instant::now();
        self.set_motions()?;
        self.begin_on_host()?;
        self.phases.integrate += begun.elapsed();
        Ok(())
    }

    fn middle(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.set_middle()?;
        self.phases.integrate += begun.elapsed();
        Ok(())
    }

    fn append_near(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let gpu = self.gpu.clone();
        let mut found = self.separate(gpu.record(), false)?;
        let overlap = |found: &Report| f64::from(f32::from_bits(found.worst));
        if self.first.is_led_astray(&self.setup, self.start.part, overlap(&found)) {
            self.first.ahead = false;
            self.set_motions()?;
            found = self.separate(gpu.record(), false)?;
        }
        if self.start.part != Part::FromMiddle {
            self.first.overlap = overlap(&found);
        }
        self.change_rows(false, |rows, record, made| {
            rows.begin(record, made)?;
            rows.incidence(record, made)
        })?;
        let Device { gpu, setup, first, narrow, rows, start, hosted, .. } = &mut *self;
        if let Some(hosted) = hosted {
            let found = (first.is_ahead(start.part), first.overlap);
            hosted.take_first((gpu, setup), &narrow.candidates.lists, rows, found)?;
        }
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    fn solve(&mut self, tolerance: f64) -> Result<Outcome, Fault> {
        let begun = Instant::now();
        let Device { gpu, narrow, rows, solve, hosted, .. } = &mut *self;
        let outcome = match hosted {
            Some(hosted) => {
                solve.tolerance = tolerance;
                hosted.solve(gpu, (&mut narrow.candidates, rows), tolerance)?
            }
            None => solve.solve(gpu, &mut narrow.candidates, rows, tolerance)?,
        };
        self.phases.solve += begun.elapsed();
        if outcome.status == Status::TooLarge {
            return Err(Fault::TooLarge { step: self.start.step, rows: self.constraints() });
        }
        Ok(outcome)
    }

    fn trial(&mut self, violating: f64) -> Result<Overlap, Fault> {
        self.trial.violating = violating - self.setup.rounding;
        let begun = Instant::now();
        let gpu = self.gpu.clone();
        if let Some(hosted) = &mut self.hosted {
            hosted.write_trial(&gpu, &self.setup, &self.rows, self.start.bodies);
        }
        let mut record = gpu.record();
        record.stage("integrate");
        let (stages, Device { motions, first, rows, trial, .. }) = (self.stages(), &*self);
        trial.record_move(stages, &mut record, (motions, &rows.problem.velocity), &stages.states.trial);
        trial.record_sweep(stages, &mut record, motions, first.poses(stages));
        self.trial.found = self.separate(record, true)?;
        self.phases.narrow_phase += begun.elapsed();
        let mut overlap = self.trial.found.overlap(&self.setup.walls);
        if overlap.worst > 0.0 {
            overlap.worst += self.setup.rounding;
        }
        if let Some(hosted) = &self.hosted {
            (overlap.stretch, overlap.bond) = hosted.stretch();
        }
        Ok(overlap)
    }

    fn append_violations(&mut self, over_corrects: bool) -> Result<(), Fault> {
        let begun = Instant::now();
        let surplus = if over_corrects { Surplus::of(self.setup.thinnest) } else { Surplus::NONE };
        self.change_rows(true, |rows, record, made| {
            rows.extend(record, made, surplus)?;
            rows.incidence(record, made)
        })?;
        let Device { gpu, setup, narrow, rows, hosted, .. } = &mut *self;
        if let Some(hosted) = hosted {
            hosted.take_appended((gpu, setup), &narrow.candidates.lists, rows)?;
        }
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    fn tighten_violations(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.change_rows(true, RowSet::tighten)?;
        if let Some(hosted) = self.hosted.as_mut().filter(|_| self.rows.next <= self.rows.problem.rows) {
            hosted.take_offsets(&self.gpu, &self.setup, &self.rows)?;
        }
        self.phases.narrow_phase += begun.elapsed();
        if self.rows.next > self.rows.problem.rows { self.append_violations(false) } else { Ok(()) }
    }

    fn renew_bonds(&mut self) -> Result<(), Fault> {
        if let Some(hosted) = &mut self.hosted {
            hosted.renew_bonds();
        }
        Ok(())
    }

    fn effect(&mut self, gap: f64) -> Result<Effect, Fault> {
        if let Some(hosted) = &self.hosted {
            return Ok(hosted.effect(gap));
        }
        // All steps use the same gap in kernels.
        Ok(self.effects().of_trial(&self.trial.found)?)
    }

    /// Only the host can relax rows. Where the device solves, the CPU repeats the step.
    fn relax(&mut self, allowed: f64) -> Result<Option<Outcome>, Fault> {
        Ok(self.hosted.as_mut().and_then(|hosted| hosted.relax(allowed)))
    }

    fn two_sided(&mut self) -> Option<&mut dyn TwoSided> {
        None
    }

    /// The effect of contact reports this at the end of the attempt.
    fn throws(&mut self, _gap: f64) -> Result<bool, Fault> {
        Ok(false)
    }

    fn passed(&mut self) -> Result<Option<Passed>, Fault> {
        let begun = Instant::now();
        let passed = self.find_passed()?;
        self.phases.narrow_phase += begun.elapsed();
        Ok(passed)
    }

    fn accept(&mut self) -> Result<Phases, Fault> {
        let begun = Instant::now();
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("integrate");
        let (stages, Device { states, motions, narrow, rows, trial, .. }) = (self.stages(), &*self);
        trial.record_arrival(stages, &mut record, motions, &states.trial);
        if let Some(bonds) = &motions.bonds {
            bonds.record_breaking(stages, &mut record, &states.trial);
        }
        rows.remember(&mut record, &narrow.candidates.lists);
        record.submit()?;
        let broken = self.hosted.as_mut().map(HostedRows::accept).unwrap_or_default();
        if let Some(bonds) = &self.motions.bonds {
            bonds.add_broken(&gpu, &broken.of_scene);
        }
        self.broken = (broken.of_scene.len() + broken.of_daughters.len()) as u32;
        self.start.ancestry.part(&broken.of_daughters);
        let Device { setup, accepted, states, start, .. } = &mut *self;
        states.accept();
        accepted.bodies = start.bodies;
        accepted.step += 1;
        accepted.changed = false;
        let ends = setup.time.after(accepted.step);
        start.ancestry.accept(if setup.midpoint { 2 } else { 1 }, ends);
        accepted.state = OnceLock::new();
        self.phases.integrate += begun.elapsed();
        Ok(std::mem::take(&mut self.phases))
    }

    fn broken_bonds(&self) -> u32 {
        self.broken
    }

    fn take_again(&mut self, take: &mut Take<'_>) -> Result<(), Fault> {
        if self.setup.planar { self.take_on_cpu::<PLANAR>(take) } else { self.take_on_cpu::<SPATIAL>(take) }
    }

    fn multipliers(&self) -> Result<Vec<f64>, Fault> {
        let problem = &self.rows.problem;
        let bytes = problem.rows * problem.gamma.element() as u64;
        let read = self.gpu.record().read(&[(&problem.gamma, 0..bytes)])?;
        Ok(self.setup.precision.decode(&read[0]))
    }

    fn stored_lcp(&self, start: Vec<f64>) -> Result<Stored, Fault> {
        if self.setup.planar {
            let (problem, gamma) = self.lcp::<PLANAR>()?;
            return Ok(Stored::new(&problem, start, &gamma));
        }
        let (problem, gamma) = self.lcp::<SPATIAL>()?;
        Ok(Stored::new(&problem, start, &gamma))
    }

    fn constraints(&self) -> usize {
        self.hosted.as_ref().map_or(self.rows.problem.rows as usize, HostedRows::rows)
    }
}
