//! A simulation that several processes take together: rank 0 leads, the others do what it says.
//!
//! All of them have the same scene and take the same steps, each with its bodies. Rank 0 reads or makes the state
//! that they start from and gives each its part; it gathers the state when it is asked for it.

use super::home::Home;
use super::{Beginning, Simulation};
use crate::backend::cpu::Cpu;
use crate::backend::cpu::domain::{Given, Part, among, shares};
use crate::freedom::{PLANAR, SPATIAL};
use crate::lcp::SolverKind;
use crate::processes::{END, GATHER, Processes, START, START_WITH_A_PART, STEP};
use crate::scene::Scene;
use crate::shape::Shape;
use crate::step::{Fault, State, Stepper};

/// A scene and a state in a message.
pub type Pack = fn(&Scene, &State) -> Result<Vec<u8>, String>;

/// How processes take a simulation together.
#[derive(Clone, Copy)]
pub struct Together {
    processes: Processes,
    pack: Pack,
}

/// Numbers of the whole scene that rank 0 sends to every rank, where each has a part of the bodies.
pub type OfAll = [u64; 8];

/// What rank 0 said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    /// There is nothing more to do.
    End,
    /// A scene and a state to start from, as packed.
    Start(Vec<u8>),
    /// The same without bodies, and what is known of them all: each process is given a part.
    StartWithAPart(Vec<u8>, OfAll),
    /// To take a step.
    Step,
    /// To give what is remembered of pairs.
    Gather,
}

impl Together {
    /// Of these processes; `pack` puts what rank 0 starts from in a message for the others.
    pub fn new(processes: Processes, pack: Pack) -> Self {
        Together { processes, pack }
    }

    /// The processes.
    pub fn processes(&self) -> Processes {
        self.processes
    }

    fn leads(&self) -> bool {
        self.processes.rank() == 0
    }

    /// Waits for what rank 0 says.
    pub fn hear(&self) -> Said {
        let mut message = self.processes.hear();
        match message.first() {
            Some(&START) => Said::Start(message.split_off(1)),
            Some(&START_WITH_A_PART) => {
                let packed = message.split_off((1 + size_of::<OfAll>()).min(message.len()));
                let numbers = message.get(1..).unwrap_or_default().as_chunks::<8>().0;
                let number = |k: usize| numbers.get(k).map_or(0, |bytes| u64::from_le_bytes(*bytes));
                Said::StartWithAPart(packed, std::array::from_fn(number))
            }
            Some(&STEP) => Said::Step,
            Some(&GATHER) => Said::Gather,
            _ => Said::End,
        }
    }

    /// Says to the others that there is nothing more to do.
    pub fn end(&self) {
        self.processes.tell(&[END]);
    }

    /// Whether steps of a scene may be shared out: by solvers that can, where no LCP is kept, which is whole.
    fn shares(&self, scene: &Scene) -> bool {
        let can = matches!(scene.solver.kind, SolverKind::Auto | SolverKind::PairBlockCg);
        can && scene.solver.dump.is_none() && shares(&scene.model(), self.processes)
    }

    /// What takes this process's part of the steps of a scene; `given` is what it has of the state, where that is a
    /// part.
    pub(super) fn backend(&self, scene: &Scene, state: State, given: Option<Given>) -> Result<Box<dyn Stepper>, Fault> {
        let (model, who) = (scene.model(), (self.processes, self.shares(scene)));
        Ok(match scene.planar {
            true => Box::new(Cpu::<PLANAR, _>::together(&model, state, who, given)?),
            false => Box::new(Cpu::<SPATIAL, _>::together(&model, state, who, given)?),
        })
    }

    /// Starts a simulation where rank 0 does, and has the others start there: with all bodies, or where steps are
    /// shared out each with a part.
    pub(super) fn start(self, scene: Scene, mut state: State, beginning: Beginning) -> Result<Simulation, Fault> {
        if !self.leads() || self.processes.size() == 1 {
            return self.begin(scene, beginning, state, None);
        }
        if !self.shares(&scene) || among(self.processes, state.bodies.len()).is_none() {
            let packed = (self.pack)(&scene, &state).map_err(Fault::Processes)?;
            self.processes.tell(&[&[START], packed.as_slice()].concat());
            return self.begin(scene, beginning, state, None);
        }
        if let Some(body) = state.bodies.first_custom() {
            let what = format!("body {body} has a custom shape, which no other process can be given");
            return Err(Fault::Processes(what));
        }
        let thinnest = state.bodies.shape.iter().map(Shape::thickness).fold(f64::INFINITY, f64::min);
        let (all, size) = (state.bodies.len(), self.processes.size());
        let parts = (0..size).map(|rank| Part::pack([rank, size], &state)).collect();
        state.warm = Vec::new();
        state.bodies = state.bodies.none_like();
        let packed = (self.pack)(&scene, &state).map_err(Fault::Processes)?;
        let Beginning { cutoff, parts_first, home, .. } = beginning;
        let [x, y, z, radius] = home.numbers().map(f64::to_bits);
        let numbers = [all as u64, cutoff.to_bits(), thinnest.to_bits(), u64::from(parts_first), x, y, z, radius];
        let bytes = numbers.map(u64::to_le_bytes);
        self.processes.tell(&[&[START_WITH_A_PART], bytes.as_flattened(), packed.as_slice()].concat());
        self.take_part(parts, scene, state, numbers)
    }

    /// Starts with this process's part, of what rank 0 gives to all.
    fn take_part(
        self,
        parts: Vec<Vec<u64>>,
        scene: Scene,
        mut state: State,
        [all, cutoff, thinnest, parts_first, home @ ..]: OfAll,
    ) -> Result<Simulation, Fault> {
        let come = self.processes.deliver(parts);
        let ranks = [self.processes.rank(), self.processes.size()];
        let part = Part::unpack(ranks, all as usize, &come[0], &mut state);
        let [cutoff, thinnest] = [cutoff, thinnest].map(f64::from_bits);
        let home = Home::of_numbers(home.map(f64::from_bits));
        let beginning = Beginning { home, ..Beginning::of(&state, cutoff, parts_first > 0) };
        self.begin(scene, beginning, state, Some(Given { part, cutoff, thinnest }))
    }

    fn begin(
        self,
        scene: Scene,
        beginning: Beginning,
        state: State,
        given: Option<Given>,
    ) -> Result<Simulation, Fault> {
        let backend = self.backend(&scene, state, given)?;
        Simulation::begin(scene, beginning, backend)
    }
}

impl Simulation {
    /// Starts where rank 0 does, as it said, with what it gives.
    pub(crate) fn start_with_a_part(
        together: Together,
        scene: Scene,
        state: State,
        numbers: OfAll,
    ) -> Result<Self, Fault> {
        let none = vec![Vec::new(); together.processes.size()];
        together.take_part(none, scene, state, numbers)
    }
}
