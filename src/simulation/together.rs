//! A simulation on several processes: rank 0 sends commands, the others follow them.
//!
//! All have the same scene and take the same steps, each with its own bodies. Rank 0 reads or makes the initial state
//! and sends each process its part. It gathers the state when it is requested.

use super::initial_region::InitialRegion;
use super::{Beginning, Simulation};
use crate::backend::cpu::Cpu;
use crate::backend::cpu::domain::{LocalState, Part, among, shares};
use crate::freedom::{PLANAR, SPATIAL};
use crate::lcp::SolverKind;
use crate::processes::{END, GATHER, Processes, START, START_PART, STEP};
use crate::scene::Scene;
use crate::shape::Shape;
use crate::step::{Fault, State, Stepper};

/// Packs a scene and a state into a message.
pub type Pack = fn(&Scene, &State) -> Result<Vec<u8>, String>;

/// Runs a simulation on several processes.
#[derive(Clone, Copy)]
pub struct Together {
    processes: Processes,
    pack: Pack,
}

/// Scalars of the whole simulation that rank 0 sends with a part of the bodies.
pub type GlobalScalars = [u64; 8];

/// A command of rank 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// End.
    End,
    /// Start from this packed scene and state.
    Start(Vec<u8>),
    /// Start from this packed scene and state without bodies. Each process receives a part of the bodies.
    StartPart(Vec<u8>, GlobalScalars),
    /// Take a step.
    Step,
    /// Gather the state.
    Gather,
}

impl Together {
    /// A simulation on these processes; `pack` makes the message with the scene and state of rank 0.
    pub fn new(processes: Processes, pack: Pack) -> Self {
        Together { processes, pack }
    }

    /// The processes.
    pub fn processes(&self) -> Processes {
        self.processes
    }

    fn is_root(&self) -> bool {
        self.processes.rank() == 0
    }

    /// Waits for the next command of rank 0.
    pub fn receive(&self) -> Command {
        let mut message = self.processes.receive();
        match message.first() {
            Some(&START) => Command::Start(message.split_off(1)),
            Some(&START_PART) => {
                let packed = message.split_off((1 + size_of::<GlobalScalars>()).min(message.len()));
                let numbers = message.get(1..).unwrap_or_default().as_chunks::<8>().0;
                let number = |k: usize| numbers.get(k).map_or(0, |bytes| u64::from_le_bytes(*bytes));
                Command::StartPart(packed, std::array::from_fn(number))
            }
            Some(&STEP) => Command::Step,
            Some(&GATHER) => Command::Gather,
            _ => Command::End,
        }
    }

    /// Sends the other processes the command to end.
    pub fn end(&self) {
        self.processes.broadcast(&[END]);
    }

    /// Whether steps of a scene can be distributed: the solver must support it, saved LCPs need all rows. Steps with
    /// friction, restitution, implicit bonds or walls under a load are not distributed.
    fn shares(&self, scene: &Scene) -> bool {
        let supported = matches!(scene.solver.kind, SolverKind::Auto | SolverKind::PairBlockCg);
        supported
            && scene.solver.dump.is_none()
            && scene.friction().is_none()
            && scene.contact.restitution.is_none()
            && scene.bonds().first_implicit().is_none()
            && scene.growth.iter().all(|growth| growth.bond_daughters.is_none())
            && scene.walls.iter().all(|wall| wall.load().is_none())
            && shares(&scene.model(), self.processes)
    }

    /// The backend of this process; `local` is its part of the state, if the state is distributed.
    pub(super) fn backend(
        &self,
        scene: &Scene,
        state: State,
        local: Option<LocalState>,
    ) -> Result<Box<dyn Stepper>, Fault> {
        let (model, processes) = (scene.model(), (self.processes, self.shares(scene)));
        Ok(match scene.planar {
            true => Box::new(Cpu::<PLANAR, _>::together(&model, state, processes, local)?),
            false => Box::new(Cpu::<SPATIAL, _>::together(&model, state, processes, local)?),
        })
    }

    /// Starts a simulation on rank 0 and tells the others to start: with all bodies, or each with a part if steps are
    /// distributed.
    pub(super) fn start(self, scene: Scene, mut state: State, beginning: Beginning) -> Result<Simulation, Fault> {
        if !self.is_root() || self.processes.size() == 1 {
            return self.begin(scene, beginning, state, None);
        }
        if !state.bodies.columns.is_empty() {
            let what = "bodies have values of their own, which are not sent to other processes";
            return Err(Fault::Processes(what.into()));
        }
        if !self.shares(&scene) || among(self.processes, state.bodies.len()).is_none() {
            let packed = (self.pack)(&scene, &state).map_err(Fault::Processes)?;
            self.processes.broadcast(&[&[START], packed.as_slice()].concat());
            return self.begin(scene, beginning, state, None);
        }
        if let Some(body) = state.bodies.shape.iter().position(Shape::is_general) {
            let name = state.bodies.shape[body].name();
            let what = format!("body {body} is a {name}, which cannot be sent to other processes; use one process");
            return Err(Fault::Processes(what));
        }
        let thinnest = state.bodies.shape.iter().map(Shape::thickness).fold(f64::INFINITY, f64::min);
        let (all, size) = (state.bodies.len(), self.processes.size());
        let parts = (0..size).map(|rank| Part::pack([rank, size], &state)).collect();
        state.warm = Vec::new();
        state.bodies = state.bodies.none_like();
        let packed = (self.pack)(&scene, &state).map_err(Fault::Processes)?;
        let Beginning { cutoff, parts_first, region, .. } = beginning;
        let [x, y, z, radius] = region.numbers().map(f64::to_bits);
        let numbers = [all as u64, cutoff.to_bits(), thinnest.to_bits(), u64::from(parts_first), x, y, z, radius];
        let bytes = numbers.map(u64::to_le_bytes);
        self.processes.broadcast(&[&[START_PART], bytes.as_flattened(), packed.as_slice()].concat());
        self.start_part(parts, scene, state, numbers)
    }

    /// Starts with the part that rank 0 sends to this process.
    fn start_part(
        self,
        parts: Vec<Vec<u64>>,
        scene: Scene,
        mut state: State,
        [all, cutoff, thinnest, parts_first, region @ ..]: GlobalScalars,
    ) -> Result<Simulation, Fault> {
        let come = self.processes.all_to_all(parts);
        let ranks = [self.processes.rank(), self.processes.size()];
        let part = Part::unpack(ranks, all as usize, &come[0], &mut state);
        let [cutoff, thinnest] = [cutoff, thinnest].map(f64::from_bits);
        let region = InitialRegion::of_numbers(region.map(f64::from_bits));
        let beginning = Beginning { region, ..Beginning::of(&state, cutoff, parts_first > 0) };
        self.begin(scene, beginning, state, Some(LocalState { part, cutoff, thinnest }))
    }

    fn begin(
        self,
        scene: Scene,
        beginning: Beginning,
        state: State,
        local: Option<LocalState>,
    ) -> Result<Simulation, Fault> {
        let backend = self.backend(&scene, state, local)?;
        Simulation::begin(self.into(), scene, beginning, backend)
    }
}

impl Simulation {
    /// Starts on another rank with the part that rank 0 sends to it.
    pub(crate) fn start_part(
        together: Together,
        scene: Scene,
        state: State,
        numbers: GlobalScalars,
    ) -> Result<Self, Fault> {
        let none = vec![Vec::new(); together.processes.size()];
        together.start_part(none, scene, state, numbers)
    }
}
