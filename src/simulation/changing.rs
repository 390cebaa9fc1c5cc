//! The changes of a scene during its simulation.

use super::change::{Change, ChangeError, Limits, Which};
use super::leaving::taken_out;
use super::{Compute, Simulation};
use crate::error::Error;
use crate::scene::changes::Changed;
use crate::scene::{KeyChange, Scene};
use crate::step::{Fault, State};
use serde_json::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// What a simulation needs of its scene's changes.
pub(super) struct Changing {
    /// The scene before its changes.
    whole: Scene,
    /// Changes that were made.
    made: usize,
    /// The steps before the next one; none after the last.
    due: Option<u64>,
}

impl Changing {
    /// Starts the simulation of a scene with changes from a state. A change that is due at the state is made by the
    /// next step, as in a simulation that came there by itself.
    pub(super) fn start(compute: &Compute, whole: Scene, state: State) -> Result<Simulation, Fault> {
        let refuse = |what: String| Fault::Change { step: state.step, what };
        if compute.is_shared() {
            return Err(refuse("a scene with `changes` runs on one process".into()));
        }
        let (mut scene, mut made, mut due) = (whole.clone(), 0, None);
        // That of the whole run, where a change of the step size moves `time.start`.
        scene.output.every = scene.output_every();
        let mut from = 0;
        while made < whole.changes.len() {
            let next = whole.changed(&scene, made, from).map_err(|fault| refuse(fault.to_string()))?;
            if next.step >= state.step {
                due = Some(next.step);
                break;
            }
            (scene, from, made) = (next.scene, next.step, made + 1);
        }
        let mut simulation = Simulation::start_plain(compute, scene, state)?;
        simulation.changing = Some(Box::new(Changing { whole, made, due }));
        Ok(simulation)
    }
}

/// The state with the bodies that a change removes and adds; `scene` has the values of the change.
fn edited<'s>(scene: &Scene, state: Cow<'s, State>, change: &KeyChange) -> Result<Cow<'s, State>, ChangeError> {
    if !change.is_of_bodies() {
        return Ok(state);
    }
    let edits = Change::new().remove_bodies(Which::Ids(change.remove.clone())).add_bodies(change.add.clone());
    Ok(Cow::Owned(Limits::of(scene).apply(scene, &state, &edits)?.state))
}

impl Simulation {
    /// The scene with which the simulation was started: [`Simulation::scene`] before its changes.
    pub fn whole_scene(&self) -> &Scene {
        self.changing.as_ref().map_or(&self.scene, |changing| &changing.whole)
    }

    /// The number of the scene's changes that were made.
    pub fn changes_made(&self) -> usize {
        self.changing.as_ref().map_or(0, |changing| changing.made)
    }

    /// The scene of the next step: with the changes that are due at the present state.
    pub fn coming_scene(&self) -> Scene {
        let (mut scene, step) = (self.scene.clone(), self.steps());
        let whole = self.whole_scene();
        for index in self.changes_made()..whole.changes.len() {
            match whole.changed(&scene, index, step) {
                Ok(changed) if changed.step <= step => scene = changed.scene,
                _ => break,
            }
        }
        scene
    }

    /// The state that the next step begins with: with the bodies that changes remove and add at the present state.
    ///
    /// # Errors
    /// [`Fault::Device`] if the device does not respond; [`Fault::Change`] if the next step would fail so.
    pub fn coming_state(&self) -> Result<Cow<'_, State>, Fault> {
        let (mut scene, mut state, step) = (Cow::Borrowed(&self.scene), Cow::Borrowed(self.state()?), self.steps());
        let whole = self.whole_scene();
        let coming = &whole.changes[self.changes_made()..];
        if !coming.iter().any(KeyChange::is_of_bodies) {
            return Ok(state);
        }
        for index in self.changes_made()..whole.changes.len() {
            match whole.changed(&scene, index, step) {
                Ok(changed) if changed.step <= step => scene = Cow::Owned(changed.scene),
                _ => break,
            }
            let refuse = |fault: ChangeError| Fault::Change { step, what: format!("changes.{index}: {fault}") };
            state = edited(&scene, state, &whole.changes[index]).map_err(refuse)?;
        }
        Ok(state)
    }

    /// Adds a change to those of the scene: other values of dotted keys, from the present state on. The simulation then
    /// has the bits of one that was started with this change.
    ///
    /// ```
    /// use relcp::{Scene, Simulation};
    /// let mut simulation = Simulation::new(Scene::built_in("three-capsules")?)?;
    /// simulation.step()?;
    /// simulation.add_change([("contact.overlap_tolerance".into(), 1e-4.into())].into())?;
    /// simulation.step()?;
    /// assert_eq!(simulation.whole_scene().changes.len(), 1);
    /// # Ok::<(), relcp::Error>(())
    /// ```
    ///
    /// # Errors
    /// What the scene refuses, a device that does not support the changed scene, or bodies that its method does not
    /// support; nothing is changed then.
    pub fn add_change(&mut self, set: BTreeMap<String, Value>) -> Result<(), Error> {
        self.add_key_change(KeyChange::new(self.time(), set))
    }

    /// The same of a change that may also remove and add bodies; its time becomes the present one.
    ///
    /// # Errors
    /// As [`Simulation::add_change`], and ids that no body has.
    pub fn add_key_change(&mut self, change: KeyChange) -> Result<(), Error> {
        let (made, step, time) = (self.changes_made(), self.steps(), self.time());
        if self.compute.is_shared() {
            let what = "a run on several processes cannot be changed".into();
            return Err(Fault::Change { step, what }.into());
        }
        let mut whole = self.whole_scene().clone();
        // After those that are due at this state already.
        let place = whole.changes.partition_point(|change| change.at <= time).max(made);
        whole.changes.insert(place, KeyChange { at: time, ..change });
        let mut before = self.scene.clone();
        // That of the whole run, where a change of the step size moves `time.start`.
        before.output.every = before.output_every();
        before.changes.clone_from(&whole.changes);
        let due = whole.changed(&before, made, step)?.step;
        let (mut scene, mut state) = (before.clone(), Cow::Borrowed(self.state()?));
        for index in made..=place {
            scene = whole.changed(&scene, index, step)?.scene;
            state = edited(&scene, state, &whole.changes[index])?;
        }
        // Those that are to come must still be valid; those that were made are.
        let (mut later, mut from) = (scene.clone(), step);
        for index in place + 1..whole.changes.len() {
            let changed = whole.changed(&later, index, from)?;
            (later, from) = (changed.scene, changed.step);
        }
        if self.device().is_some() {
            Compute::check(&whole)?;
        }
        // What a scene cannot know shows when its backend starts.
        Simulation::start_plain(&self.compute, scene, state.into_owned())?;
        self.scene = before;
        self.changing = Some(Box::new(Changing { whole, made, due: Some(due) }));
        Ok(())
    }

    /// Makes the present state the end of the simulation and of its scene.
    pub(crate) fn end_here(&mut self) {
        let end = self.time();
        let whole = self.changing.as_mut().map(|changing| &mut changing.whole);
        for scene in [Some(&mut self.scene), whole].into_iter().flatten() {
            scene.output.every = scene.output_every();
            scene.time.end = end;
        }
    }

    /// Makes the changes that are due before the next step.
    pub(super) fn make_changes(&mut self) -> Result<(), Fault> {
        let steps = self.steps();
        while self.changing.as_ref().is_some_and(|changing| changing.due.is_some_and(|due| due <= steps)) {
            self.make_change()?;
        }
        Ok(())
    }

    fn make_change(&mut self) -> Result<(), Fault> {
        let Some(changing) = &self.changing else { return Ok(()) };
        let (made, step) = (changing.made, self.steps());
        let refuse = |what: String| Fault::Change { step, what };
        let whole = &changing.whole;
        let of = |scene: &Scene, index| whole.changed(scene, index, step).map_err(|fault| refuse(fault.to_string()));
        let Changed { scene, keeps_multipliers, .. } = of(&self.scene, made)?;
        let due = match made + 1 < scene.changes.len() {
            true => Some(of(&scene, made + 1)?.step),
            false => None,
        };
        let before = self.state()?;
        let edited = edited(&scene, Cow::Borrowed(before), &whole.changes[made]);
        let mut state = edited.map_err(|fault| refuse(format!("changes.{made}: {fault}")))?.into_owned();
        let gone = match whole.changes[made].remove.is_empty() {
            true => Vec::new(),
            false => taken_out(&before.bodies, &state.bodies, step + 1, self.time()),
        };
        if !keeps_multipliers {
            state.warm.clear();
        }
        log::info!("step {step}: change {made} of the scene");
        let mut next = Simulation::start_plain(&self.compute, scene, state)?;
        for force in self.backend.take_forces() {
            next.backend.add_force(force);
        }
        std::mem::swap(&mut next.keep, &mut self.keep);
        next.rules = self.rules.take();
        next.taken_out = std::mem::take(&mut self.taken_out);
        next.taken_out.extend(gone);
        next.changing = self.changing.take().map(|changing| Box::new(Changing { made: made + 1, due, ..*changing }));
        *self = next;
        Ok(())
    }
}
