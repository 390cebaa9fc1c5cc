//! A simulation: a scene's bodies and the backend that steps them.

mod builder;
mod change;
#[cfg(feature = "files")]
mod changing;
mod compute;
mod initial_region;
mod leaving;
#[cfg(feature = "mpi")]
mod together;
mod worth;

pub use builder::SimulationBuilder;
pub use change::{Cell, CellState, CellValues, Change, ChangeError, Rules, Values, Which};
pub use compute::Compute;
#[cfg(feature = "mpi")]
pub use together::{Command, GlobalScalars, Pack, Together};
pub use worth::worth_a_device;

use crate::bodies::Bodies;
use crate::dynamics::ForceField;
use crate::error::Error;
use crate::fields::Fields;
use crate::gpu::{Gpu, Precision};
use crate::removal::Ended;
use crate::scene::{Scene, StopReason};
use crate::step::{Contact, Fault, Keep, Model, Plan, SavedLcp, State, StepReport, Stepper, contacts, max_overlap_but};
use crate::walls::{WallContact, Walls};
use change::Limits;
use initial_region::InitialRegion;
use leaving::Leaving;

/// Steps of at least this many bodies run on a thread of the pool; steps of fewer bodies have no parallel loop.
/// Entering the pool takes 13 microseconds, four times the time of a step of two bodies. Calling the loops of 1,024
/// cells from outside takes an eighth of their step.
const LEAST_BODIES_IN_POOL: usize = 256;

/// The global data of a simulation at the start.
#[derive(Clone, Copy)]
struct Beginning {
    cutoff: f64,
    /// Whether to separate overlapping bodies before the first step.
    parts_first: bool,
    /// The number of bodies removed before.
    removed: u64,
    region: InitialRegion,
}

impl Beginning {
    /// The data of this state.
    fn of(state: &State, cutoff: f64, parts_first: bool) -> Self {
        Beginning { cutoff, parts_first, removed: state.removed.iter().sum(), region: InitialRegion::of(&state.bodies) }
    }
}

/// A scene's bodies and the backend that steps them.
///
/// ```
/// # #[cfg(feature = "files")] {
/// use relcp::{Scene, Simulation};
/// let mut simulation = Simulation::new(Scene::load("two-ellipsoids", ["time.end=0.1"])?)?;
/// while !simulation.done() {
///     let report = simulation.step()?;
///     assert!(report.max_overlap <= 1e-5);
/// }
/// assert_eq!(simulation.state()?.bodies.len(), 2);
/// # }
/// # Ok::<(), relcp::Error>(())
/// ```
pub struct Simulation {
    scene: Scene,
    plan: Plan,
    /// What made the backend.
    compute: Compute,
    backend: Box<dyn Stepper>,
    keep: Keep,
    stopped_by: Option<StopReason>,
    /// The scene's fields, if it has some.
    fields: Option<Fields>,
    /// The removal of bodies, if the scene has rules for it.
    leaving: Option<Leaving>,
    /// The lives that ended in the last step, and by changes since.
    ended: Vec<Ended>,
    taken_out: Vec<Ended>,
    rules: Option<Box<dyn Rules>>,
    /// What the scene allows its bodies to be, once the state was changed.
    limits: Option<Box<Limits>>,
    region: InitialRegion,
    /// The solver's tolerances in f32 and in f64.
    tolerances: [f64; 2],
    /// What comes of the scene's changes, if it has some.
    #[cfg(feature = "files")]
    changing: Option<Box<changing::Changing>>,
}

impl Simulation {
    /// Starts a scene from its own bodies, on the CPU: [`Simulation::builder`] with nothing set.
    ///
    /// # Errors
    /// As [`SimulationBuilder::build`].
    pub fn new(scene: Scene) -> Result<Self, Error> {
        Self::builder(scene).build()
    }

    /// Prepares the simulation of a scene. By default it starts from the scene's own bodies, on the CPU.
    ///
    /// ```
    /// # #[cfg(feature = "files")] {
    /// use relcp::{Scene, Simulation};
    /// let scene = Scene::built_in("three-capsules")?;
    /// let mut first = Simulation::new(scene.clone())?;
    /// first.step()?;
    /// let state = first.state()?.clone();
    /// let second = Simulation::builder(scene).resume(state).build()?;
    /// assert_eq!(second.steps(), 1);
    /// # }
    /// # Ok::<(), relcp::Error>(())
    /// ```
    pub fn builder(scene: Scene) -> SimulationBuilder {
        SimulationBuilder::new(scene)
    }

    /// Steps `scene` from `state`.
    ///
    /// # Errors
    /// A [`Fault`]: the scene's method or a device does not support the bodies.
    pub(crate) fn start(compute: &Compute, scene: Scene, state: State) -> Result<Self, Fault> {
        #[cfg(feature = "files")]
        if !scene.changes.is_empty() {
            return changing::Changing::start(compute, scene, state);
        }
        Simulation::start_plain(compute, scene, state)
    }

    /// Steps `scene` from `state`, whatever its changes.
    fn start_plain(compute: &Compute, scene: Scene, mut state: State) -> Result<Self, Fault> {
        state.bodies.planar = scene.planar;
        state.next_id = state.next_id.max(scene.next_id.unwrap_or(0));
        if state.bodies.bonds.is_empty() {
            state.bodies.bonds = scene.held_bonds(&state.bodies);
        }
        state.fields = scene.fields().start(&state.fields);
        let cutoff = scene.cutoff_of(state.bodies.shape.iter().copied());
        let model = scene.model();
        let plan = Plan::new(&model, cutoff);
        let parts_first = parts_first(&scene, &model, &plan, &state);
        let beginning = Beginning::of(&state, cutoff, parts_first);
        #[cfg(feature = "mpi")]
        if let Compute::Together(together) = compute {
            // The fields of other processes would stay what they are at the start.
            if !scene.fields.is_empty() {
                let what = "a scene with `fields` runs on one process".into();
                return Err(Fault::Change { step: state.step, what });
            }
            return together.start(scene, state, beginning);
        }
        let backend = compute.backend(&scene, state)?;
        Simulation::begin(compute.clone(), scene, beginning, backend)
    }

    /// A simulation of `scene` on a backend that has the initial state.
    fn begin(compute: Compute, scene: Scene, beginning: Beginning, backend: Box<dyn Stepper>) -> Result<Self, Fault> {
        let Beginning { cutoff, parts_first, removed, region } = beginning;
        let mut plan = Plan::new(&scene.model(), cutoff);
        plan.parts_first = parts_first;
        // Where the CPU solves for a device, it does so in f64.
        let exact = Compute::host_solves(&scene);
        let solved_in = |precision| if exact { Precision::F64 } else { precision };
        let tolerances = [Precision::F32, Precision::F64].map(|of| scene.solver_tolerance(solved_in(of)));
        let keep = Keep::new(scene.solver.dump);
        let mut simulation = Simulation {
            scene,
            plan,
            compute,
            backend,
            keep,
            stopped_by: None,
            leaving: None,
            fields: None,
            ended: Vec::new(),
            taken_out: Vec::new(),
            rules: None,
            limits: None,
            region,
            tolerances,
            #[cfg(feature = "files")]
            changing: None,
        };
        simulation.fields = Some(simulation.scene.fields()).filter(|fields| !fields.is_empty());
        simulation.leaving = Leaving::of(&simulation.scene, simulation.backend.as_ref(), removed)?;
        simulation.check_stop()?;
        Ok(simulation)
    }

    /// Checks whether the scene's `growth.stop` is reached.
    fn check_stop(&mut self) -> Result<(), Fault> {
        if self.bodies() == 0 {
            self.stopped_by = Some(StopReason::NoBodies);
            return Ok(());
        }
        let Some(stop) = self.scene.stop() else { return Ok(()) };
        let radius = || self.backend.all_bodies().map(Bodies::radius);
        self.stopped_by = stop.reached(self.bodies(), self.time(), self.scene.time.dt, radius)?;
        Ok(())
    }

    /// The scene, with the changes that were made.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The state after the last accepted step. On a device it is read at the first call after a step.
    ///
    /// # Errors
    /// [`Fault::Device`] if the device does not respond.
    pub fn state(&self) -> Result<&State, Fault> {
        self.backend.state()
    }

    /// Accepted steps, including those before a resumption.
    pub fn steps(&self) -> u64 {
        self.backend.steps()
    }

    /// Bodies after the last accepted step.
    pub fn bodies(&self) -> usize {
        self.backend.bodies()
    }

    /// The precision of the computation.
    pub fn precision(&self) -> Precision {
        self.backend.precision()
    }

    /// The device that computes, if one does.
    pub fn device(&self) -> Option<&Gpu> {
        self.backend.device()
    }

    /// The backend: `cpu` or `gpu`.
    pub fn machine(&self) -> &'static str {
        if self.device().is_some() { "gpu" } else { "cpu" }
    }

    /// The time after the last accepted step.
    pub fn time(&self) -> f64 {
        self.scene.time.after(self.steps())
    }

    /// Whether the scene's end or its `growth.stop` is reached.
    pub fn done(&self) -> bool {
        self.stopped_by.is_some() || self.steps() >= self.scene.time.steps()
    }

    /// The lives that ended in the last step: first by changes before it, then by division, then by removal; the last
    /// two only if the scene has `removal`.
    pub fn ended(&self) -> &[Ended] {
        &self.ended
    }

    /// The number of bodies that the scene's `removal` has removed, including those before a resumption.
    pub fn removed(&self) -> u64 {
        self.leaving.as_ref().map_or(0, Leaving::removed)
    }

    /// Why the simulation stopped before its end: a limit of `growth.stop`, or no body is left.
    pub fn stopped_by(&self) -> Option<StopReason> {
        self.stopped_by
    }

    /// Adds an external force to those of the scene.
    ///
    /// If a device computes, this force is still computed on the host, from a state that is read back each step.
    pub fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.backend.add_force(force);
    }

    /// Takes one step.
    ///
    /// # Errors
    /// A [`Fault`]; the state is then still that of the last accepted step.
    pub fn step(&mut self) -> Result<StepReport, Fault> {
        #[cfg(feature = "files")]
        self.make_changes()?;
        self.ended = std::mem::take(&mut self.taken_out);
        let Some(mut rules) = self.rules.take() else {
            let report = self.advance()?;
            return self.finish(report);
        };
        let stepped = self.step_by(rules.as_mut());
        self.rules = Some(rules);
        stepped
    }

    /// Has the backend take a step.
    fn advance(&mut self) -> Result<StepReport, Fault> {
        self.check_runaway()?;
        self.plan.span = self.scene.time.span(self.steps() + 1);
        self.plan.tolerance = self.tolerances[usize::from(self.precision() == Precision::F64)];
        let in_pool = self.bodies() >= LEAST_BODIES_IN_POOL;
        let Simulation { backend, plan, keep, .. } = self;
        let mut report = match in_pool {
            true => rayon::scope(|_| backend.step(plan, keep))?,
            false => backend.step(plan, keep)?,
        };
        self.plan.parts_first = false;
        report.time = self.scene.time.after(report.step);
        Ok(report)
    }

    /// Takes the fields over the step, removes bodies after it, and checks whether it is the last.
    fn finish(&mut self, mut report: StepReport) -> Result<StepReport, Fault> {
        if let Some(fields) = &self.fields {
            let state = self.backend.state()?;
            let mut values = state.fields.clone();
            fields.advance(&mut values, &state.bodies, self.plan.span * self.scene.time.dt);
            self.backend.set_fields(values);
        }
        if let Some(leaving) = &mut self.leaving {
            leaving.apply(self.backend.as_mut(), &self.scene.time, &mut report)?;
            self.ended.extend_from_slice(leaving.ended());
        }
        self.check_stop()?;
        Ok(report)
    }

    /// Refuses bodies that have run away. Devices and distributed runs do not check this.
    fn check_runaway(&self) -> Result<(), Fault> {
        let left = self.backend.known_bodies().and_then(|bodies| self.region.runaway(bodies, self.steps()));
        left.map_or(Ok(()), Err)
    }

    /// The LCPs that the scene's `solver.dump` selects, of the steps since the last call, including a failed step.
    pub fn take_lcps(&mut self) -> Vec<SavedLcp> {
        self.keep.take()
    }

    /// Counts LCPs of this run that were saved before against the limit of `solver.dump`.
    pub fn count_lcps(&mut self, saved: usize) {
        self.keep.count(saved);
    }

    /// The present state as a scene to continue from, which a run writes as `final.json`.
    ///
    /// # Errors
    /// As [`Simulation::state`].
    pub fn final_scene(&self) -> Result<Scene, Fault> {
        let state = self.state()?;
        let mut scene = self.scene.final_scene(&state.bodies, self.time());
        for of in &state.fields {
            if let Some(field) = scene.fields.get_mut(&of.name) {
                field.values.clone_from(&of.values);
            }
        }
        #[cfg(feature = "files")]
        scene.changes.drain(..self.changes_made());
        let follows = State::new(Bodies { lineage: state.bodies.lineage.clone(), ..Bodies::default() }).next_id;
        scene.next_id = (state.next_id > follows).then_some(state.next_id);
        Ok(scene)
    }

    /// Every pair of bodies whose separation is at most `cutoff`, sorted by pair. See [`contacts()`].
    ///
    /// # Errors
    /// As [`Simulation::state`].
    pub fn contacts(&self, cutoff: f64) -> Result<Vec<Contact>, Fault> {
        Ok(contacts(&self.state()?.bodies, cutoff))
    }

    /// The walls at the present time.
    pub fn walls(&self) -> Walls {
        // Only the CPU moves walls by loads.
        let states = self.backend.known_bodies().map_or(&[][..], |bodies| &bodies.walls);
        self.scene.walls().at(self.time()).gone(states)
    }

    /// Every body and surface of a wall whose separation is at most `cutoff`. See
    /// [`Walls::contacts`](crate::walls::Walls::contacts).
    ///
    /// # Errors
    /// As [`Simulation::state`].
    pub fn wall_contacts(&self, cutoff: f64) -> Result<Vec<WallContact>, Fault> {
        Ok(self.walls().contacts(&self.state()?.bodies, cutoff))
    }
}

/// Whether bodies overlap that must be parted before the first step from a state: with inertia they would be thrown.
fn parts_first(scene: &Scene, model: &Model, plan: &Plan, state: &State) -> bool {
    let may_overlap = state.step == 0 || state.changed;
    may_overlap && scene.dynamics.has_inertia() && plan.promises() && {
        let walls = model.walls.at(scene.time.after(state.step)).gone(&state.bodies.walls);
        let apart = model.bonds.rigid_stretch(&state.bodies);
        max_overlap_but(&model.fixed, &state.bodies, &walls).max(apart) > scene.contact.overlap_tolerance
    }
}
