//! The start of a step: its bodies with their lengths, its parts, and the positions of walls and cell in each part.
//!
//! A step of first order has one part. A midpoint step has two: its first half, and then the whole step with the values
//! at its midpoint. Forces, mobilities and first rows are evaluated at the beginning of a part; moves begin at the
//! start of the step.

use super::Setup;
use super::ancestry::Ancestry;
use super::growing::GrowthBuffers;
use super::held::Held;
use super::part::Part;
use super::source::loads;
use super::states::{Poses, Shapes, States};
use crate::gpu::function::{Argument, Member, Part as Value, parts};
use crate::gpu::{Buffer, Gpu, GpuError, LatticePeriods, Recorder};
use crate::periodic::Periods;
use crate::step::{Model, State, Unrounded};

/// The start of a step.
pub(super) struct Start {
    /// The number of the present step, and its start time.
    pub step: u64,
    pub time: f64,
    pub part: Part,
    /// The number of bodies in the step.
    pub bodies: u64,
    /// The identities of the bodies.
    pub ancestry: Ancestry,
    pub groups_of: Buffer,
    pub growth: GrowthBuffers,
    /// The flags of fixed bodies; `None` if no body can be fixed.
    pub held: Option<Held>,
    /// The periods at the end of the present part.
    pub periods: Periods,
    lattice_periods: LatticePeriods,
    /// The periods at the beginning of the present part.
    pub periods_here: LatticePeriods,
}

impl Start {
    /// The start before the first step from `state`.
    pub fn new(
        gpu: &Gpu,
        setup: &Setup,
        model: &Model,
        state: &State,
        unrounded: &Unrounded,
    ) -> Result<Self, GpuError> {
        let mut ancestry = Ancestry::of(setup, state, unrounded.prescribed());
        Ok(Start {
            step: state.step + 1,
            time: setup.time.after(state.step),
            part: setup.first_part(),
            bodies: state.bodies.len() as u64,
            growth: GrowthBuffers::new(gpu, setup, &mut ancestry)?,
            groups_of: Buffer::with(gpu, "groups", 4, bytemuck::cast_slice(&ancestry.group))?,
            ancestry,
            held: Held::new(gpu, setup, &model.fixed.flags(&state.bodies))?,
            periods: setup.periods,
            lattice_periods: setup.lattice_periods,
            periods_here: setup.lattice_periods,
        })
    }

    /// Continues from another state.
    pub fn load(
        &mut self,
        gpu: &Gpu,
        setup: &Setup,
        model: &Model,
        state: &State,
        unrounded: &Unrounded,
    ) -> Result<(), GpuError> {
        self.ancestry = Ancestry::of(setup, state, unrounded.prescribed());
        if let Some(held) = &mut self.held {
            held.write(gpu, &model.fixed.flags(&state.bodies))?;
        }
        self.growth.write_changed(gpu, setup, &mut self.ancestry)?;
        self.growth.write_tips(gpu, setup, &self.ancestry, 0)?;
        self.bodies = state.bodies.len() as u64;
        self.groups_of.reserve(gpu, self.bodies)?;
        self.groups_of.write(gpu, 0, bytemuck::cast_slice(&self.ancestry.group));
        self.begin(setup, state.step);
        self.periods = state.bodies.periods;
        Ok(())
    }

    /// Begins the step after `steps` steps.
    pub fn begin(&mut self, setup: &Setup, steps: u64) {
        (self.step, self.time) = (steps + 1, setup.time.after(steps));
        self.part = setup.first_part();
    }

    /// The times at which the present part begins and ends.
    pub fn span(&self, setup: &Setup) -> [f64; 2] {
        [self.time, self.time + setup.length_of(self.part)]
    }

    /// The time at which forces are evaluated: the start, or the middle once it has been computed.
    pub fn time_of_loads(&self, setup: &Setup) -> f64 {
        self.time + if self.part == Part::FromMiddle { 0.5 * setup.dt } else { 0.0 }
    }

    /// Sets the periods at the beginning and the end of the present part, if they change. Returns the periods if they
    /// differ from those of the last part.
    pub fn place_cell(&mut self, setup: &Setup) -> Result<Option<LatticePeriods>, GpuError> {
        let Some(strain) = &setup.strain else { return Ok(None) };
        let [begin, end] = self.span(setup);
        let periods = strain.periods(end);
        self.periods_here = LatticePeriods::of(setup.lattice, strain.periods(begin).numbers())?;
        if periods == self.periods {
            return Ok(None);
        }
        self.lattice_periods = LatticePeriods::of(setup.lattice, periods.numbers())?;
        self.periods = periods;
        Ok(Some(self.lattice_periods))
    }
}

/// The inputs of the stages of a step.
#[derive(Clone, Copy)]
pub(super) struct Stages<'a> {
    pub gpu: &'a Gpu,
    pub setup: &'a Setup,
    pub states: &'a States,
    pub start: &'a Start,
}

/// The parameters of kernels for the present part: the number of bodies, the length of the part and its root, the
/// periods at its end, the strain rates of the cell, and the share of each window of the forces.
impl Argument for Stages<'_> {
    fn parts() -> Vec<Value> {
        let length = [("bodies", "u32"), ("dt", "real"), ("root_dt", "real"), ("periods", LatticePeriods::TYPE)];
        parts(&[&length[..], &[("strain", "vec3r"), ("shares", "array<vec4r, SHARES>")]].concat())
    }

    fn write(&self, nth: usize, to: Member<'_>) {
        let dt = self.setup.length_of(self.start.part);
        match nth {
            0 => to.words(&[self.start.bodies as u32]),
            1 => to.reals(&[dt]),
            2 => to.reals(&[dt.sqrt()]),
            3 => self.start.lattice_periods.write(0, to),
            4 => to.reals(&self.setup.strain.map_or([0.0; 3], |strain| strain.rates(self.start.time).to_array())),
            _ => {
                let (windows, span) = (loads::windows(&self.setup.forces), self.start.span(self.setup));
                to.reals(&windows.iter().map(|window| window.share(span)).collect::<Vec<_>>());
            }
        }
    }
}

impl<'a> Stages<'a> {
    /// The poses at the beginning of the present part.
    pub fn here(self) -> &'a Poses {
        self.states.here(self.start.part)
    }

    /// The shapes of bodies in the first rows of the present part.
    pub fn here_shapes(self) -> &'a Shapes {
        self.states.here_shapes(self.start.part)
    }

    /// Records the growth of the bodies in a part of the step.
    pub fn record_growth(self, record: &mut Recorder<'_>) {
        self.start.growth.record(record, self.states.end_shapes(), self.start.bodies);
    }
}
