//! The state that a device stores, and the steps that it takes.

use super::ancestry::Ancestry;
use super::hosted::HostedRows;
use super::states::{Poses, Shapes, States};
use super::{Device, unrounded};
use crate::bodies::{Bodies, Columns, Lineage};
use crate::dynamics::ForceField;
use crate::fields::Concentration;
use crate::gpu::{Gpu, GpuError, Precision};
use crate::step::{Divided, Fault, Keep, Keeper, LIFE_WORDS, Lives, Plan, State, StepReport, Stepper, Unrounded, step};
use crate::walls::surface_of;
use crate::warm::Warm;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// The host's copy of the last accepted state, except poses and shapes.
pub(super) struct Accepted {
    /// The number of steps taken.
    pub step: u64,
    pub bodies: u64,
    /// The number of bodies that each rule of removal has removed.
    pub removed: Vec<u64>,
    /// Whether bodies were placed or lengthened since the last step.
    pub changed: bool,
    /// The concentrations of the scene's fields.
    pub fields: Vec<Concentration>,
    /// The whole state, if it has been read.
    pub state: OnceLock<State>,
}

impl Accepted {
    /// From a state; the device may have additional digits.
    pub fn of(state: &State) -> Self {
        let (bodies, removed, fields) = (state.bodies.len() as u64, state.removed.clone(), state.fields.clone());
        Accepted { step: state.step, bodies, removed, changed: state.changed, fields, state: OnceLock::new() }
    }
}

impl Device {
    /// Reads the bodies of the present step in the given poses and shapes.
    pub(super) fn download(&self, poses: &Poses, shapes: &Shapes) -> Result<Bodies, GpuError> {
        let Ancestry { lineage, group, .. } = &self.start.ancestry;
        let bodies = self.download_first(poses, shapes, (lineage.clone(), group.clone()))?.0;
        Ok(Bodies { columns: self.start.ancestry.columns(), ..bodies })
    }

    /// The first bodies of a state, as many as have a lineage.
    fn download_first(
        &self,
        poses: &Poses,
        shapes: &Shapes,
        (lineage, group): (Vec<Lineage>, Vec<u32>),
    ) -> Result<(Bodies, Unrounded), GpuError> {
        let Device { gpu, setup, start, motions, .. } = self;
        let mut read = unrounded::download(gpu, setup, poses, shapes, lineage.len() as u64)?;
        start.ancestry.write_radii(&mut read.shape);
        let bodies = Bodies {
            periods: start.periods,
            planar: setup.planar,
            shape: read.shape,
            position: read.position,
            orientation: read.orientation,
            velocity: read.velocity,
            angular_velocity: read.angular_velocity,
            group,
            lineage,
            columns: Columns::default(),
            bonds: Vec::new(),
            // A device refuses walls under a load.
            walls: Vec::new(),
            broken_bonds: motions.bonds.as_ref().map_or(Ok(Vec::new()), |bonds| bonds.read_broken(gpu, setup))?,
        };
        Ok((bodies, read.unrounded))
    }

    /// The state after the last accepted step; it is read back if necessary.
    pub(super) fn known_state(&self) -> Result<&State, GpuError> {
        let known = &self.accepted.state;
        if known.get().is_none() {
            let _ = known.set(self.read_state()?);
        }
        known.get().ok_or_else(|| GpuError::Refused { message: "the state is not there".into() })
    }

    fn read_state(&self) -> Result<State, GpuError> {
        let Accepted { step, bodies: count, removed, changed, fields, .. } = &self.accepted;
        let (lineage, group, next_id) = self.start.ancestry.accepted();
        // The list of a step with divisions contains pairs of bodies that did not exist in the accepted state.
        let born = |body: u32| u64::from(body) < *count;
        let mut warm = self.remembered()?;
        if let Some(hosted) = &self.hosted {
            hosted.complete(&mut warm);
        }
        warm.retain(|w| born(w.pair[0]) && (born(w.pair[1]) || surface_of(w.pair[1]).is_some()));
        let States { accepted, accepted_shapes, .. } = &self.states;
        let (mut bodies, mut unrounded) = self.download_first(accepted, accepted_shapes, (lineage, group))?;
        bodies.columns = self.start.ancestry.accepted_columns();
        let none = BTreeMap::new();
        bodies.bonds = self.setup.bonds.held(&bodies, self.hosted.as_ref().map_or(&none, HostedRows::pulls));
        let of_daughters = self.hosted.as_ref().map(|hosted| hosted.held_daughters(&bodies));
        bodies.bonds.extend(of_daughters.unwrap_or_default());
        unrounded.prescribe(&self.start.ancestry.accepted_lengths());
        let (removed, fields, unrounded) = (removed.clone(), fields.clone(), Some(unrounded));
        Ok(State { step: *step, next_id, bodies, warm, removed, changed: *changed, fields, unrounded })
    }

    fn remembered(&self) -> Result<Vec<Warm>, GpuError> {
        self.narrow.candidates.remembered(&self.gpu, &self.setup)
    }
}

impl Keeper for Device {
    fn steps(&self) -> u64 {
        self.accepted.step
    }

    fn bodies(&self) -> usize {
        self.accepted.bodies as usize
    }

    fn state(&self) -> Result<&State, Fault> {
        Ok(self.known_state()?)
    }

    fn restore(&mut self, state: &State) -> Result<(), Fault> {
        let (mut state, time) = (state.clone(), self.model.time.after(state.step));
        state.bodies.periods = self.setup.strain.map_or(self.setup.periods, |strain| strain.periods(time));
        state.bodies.planar = self.setup.planar;
        Ok(self.load(state)?)
    }

    fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.motions.plugged.push(force);
    }

    fn take_forces(&mut self) -> Vec<Box<dyn ForceField>> {
        std::mem::take(&mut self.motions.plugged)
    }

    fn all_bodies(&self) -> Result<&Bodies, Fault> {
        Ok(&self.known_state()?.bodies)
    }

    /// `None`: the bodies would have to be read back.
    fn known_bodies(&self) -> Option<&Bodies> {
        None
    }

    fn local_bodies(&self) -> Result<&Bodies, Fault> {
        Ok(&self.known_state()?.bodies)
    }

    fn lives(&self) -> Result<Lives<'_>, Fault> {
        Ok(Lives::of_all(&self.start.ancestry.lineage, &self.start.ancestry.group))
    }

    fn divided(&mut self, before: &[Lineage]) -> Result<Vec<Divided>, Fault> {
        Ok(Divided::between(before, &self.start.ancestry.lineage, &self.start.ancestry.group))
    }

    fn all_gather(&self, own: Vec<[u64; LIFE_WORDS]>) -> Vec<[u64; LIFE_WORDS]> {
        own
    }

    fn set_fields(&mut self, fields: Vec<Concentration>) {
        if let Some(state) = self.accepted.state.get_mut() {
            state.fields.clone_from(&fields);
        }
        self.accepted.fields = fields;
    }

    fn remove(&mut self, keep: &[bool], removed: &[u64]) -> Result<(), Fault> {
        let mut state = self.known_state()?.clone();
        self.start.ancestry.write_lengths(&mut state.bodies);
        state.remove(keep, removed);
        Ok(self.load(state)?)
    }
}

impl Stepper for Device {
    fn step(&mut self, plan: &Plan, keep: &mut Keep) -> Result<StepReport, Fault> {
        step(self, plan, keep)
    }

    fn device(&self) -> Option<&Gpu> {
        Some(&self.gpu)
    }

    fn precision(&self) -> Precision {
        self.setup.precision
    }
}
