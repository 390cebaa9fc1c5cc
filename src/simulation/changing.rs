//! The changes of a scene during its simulation.

use super::{Compute, Simulation};
use crate::scene::Scene;
use crate::scene::changes::Changed;
use crate::step::{Fault, State};

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

impl Simulation {
    /// The scene with which the simulation was started: [`Simulation::scene`] before its changes.
    pub fn whole_scene(&self) -> &Scene {
        self.changing.as_ref().map_or(&self.scene, |changing| &changing.whole)
    }

    /// The number of the scene's changes that were made.
    pub fn changes_made(&self) -> usize {
        self.changing.as_ref().map_or(0, |changing| changing.made)
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
        let mut state = self.state()?.clone();
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
        next.changing = self.changing.take().map(|changing| Box::new(Changing { made: made + 1, due, ..*changing }));
        *self = next;
        Ok(())
    }
}
