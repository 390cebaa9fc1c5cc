//! A simulation that several processes take together: rank 0 leads, the others do what it says.
//!
//! All of them have the same scene and take the same steps, each with its bodies. Rank 0 reads or makes the state
//! that they start from and gives each its part; it gathers the state when it is asked for it.

use super::{Beginning, Compute, Simulation};
use crate::backend::cpu::{Cpu, Given, Part, among, shares};
use crate::lcp::SolverKind;
use crate::processes::Processes;
use crate::scene::Scene;
use crate::shape::Shape;
use crate::step::{Backend, Fault, State, StepReport};
use std::hash::{DefaultHasher, Hash, Hasher};

/// What rank 0 says, as the first byte of a message.
const END: u8 = 0;
const START: u8 = 1;
const STEP: u8 = 2;
const GATHER: u8 = 3;
const START_WITH_A_PART: u8 = 4;

/// A scene and a state in a message.
pub type Pack = fn(&Scene, &State) -> Result<Vec<u8>, String>;

/// How processes take a simulation together.
#[derive(Clone, Copy)]
pub struct Together {
    processes: Processes,
    pack: Pack,
}

/// What rank 0 said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    /// There is nothing more to do.
    End,
    /// A scene and a state to start from, as packed.
    Start(Vec<u8>),
    /// The same without bodies, and what is known of them all: each process is given a part.
    StartWithAPart(Vec<u8>, [u64; 4]),
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
                let packed = message.split_off((1 + 4 * size_of::<u64>()).min(message.len()));
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

    /// Has the others give what they remember of pairs.
    pub(super) fn gather(&self) {
        if self.leads() {
            self.processes.tell(&[GATHER]);
        }
    }

    /// Whether steps of a scene may be shared out: by solvers that can, where no LCP is kept, which is whole.
    fn shares(&self, scene: &Scene) -> bool {
        let can = matches!(scene.solver.kind, SolverKind::Auto | SolverKind::PairBlockCg);
        can && scene.solver.dump.is_none() && shares(&scene.model(), self.processes)
    }

    /// A backend that takes its part of each step, where steps may be shared out.
    pub(super) fn share<const D: usize>(&self, cpu: Cpu<D>, scene: &Scene, given: Option<Given>) -> Box<dyn Backend> {
        Box::new(if self.shares(scene) { cpu.share(self.processes, given) } else { cpu })
    }

    /// Has the others start from where rank 0 does: with all bodies, or where steps are shared out each with a part.
    pub(super) fn start(&self, scene: &Scene, mut beginning: Beginning) -> Result<Beginning, Fault> {
        if !self.leads() || self.processes.size() == 1 {
            return Ok(beginning);
        }
        let state = &mut beginning.state;
        if !self.shares(scene) || among(self.processes, state.bodies.len()).is_none() {
            let packed = (self.pack)(scene, state).map_err(Fault::Processes)?;
            self.processes.tell(&[&[START], packed.as_slice()].concat());
            return Ok(beginning);
        }
        if let Some(body) = state.bodies.first_custom() {
            let what = format!("body {body} has a custom shape, which no other process can be given");
            return Err(Fault::Processes(what));
        }
        let thinnest = state.bodies.shape.iter().map(Shape::thickness).fold(f64::INFINITY, f64::min);
        let (all, size) = (state.bodies.len(), self.processes.size());
        let parts = (0..size).map(|rank| Part::pack([rank, size], state)).collect();
        state.warm = Vec::new();
        state.bodies = state.bodies.none_like();
        let packed = (self.pack)(scene, state).map_err(Fault::Processes)?;
        let numbers = [all as u64, beginning.cutoff.to_bits(), thinnest.to_bits(), u64::from(beginning.parts_first)];
        let numbers = numbers.map(u64::to_le_bytes);
        self.processes.tell(&[&[START_WITH_A_PART], numbers.as_flattened(), packed.as_slice()].concat());
        Ok(self.take_part(parts, beginning.state, numbers.map(u64::from_le_bytes)))
    }

    /// Takes up this process's part, of what rank 0 gives to all.
    fn take_part(
        &self,
        parts: Vec<Vec<u64>>,
        mut state: State,
        [all, cutoff, thinnest, parts_first]: [u64; 4],
    ) -> Beginning {
        let come = self.processes.deliver(parts);
        let ranks = [self.processes.rank(), self.processes.size()];
        let part = Part::unpack(ranks, all as usize, &come[0], &mut state);
        let [cutoff, thinnest] = [cutoff, thinnest].map(f64::from_bits);
        let given = Some(Given { part, cutoff, thinnest });
        Beginning { state, cutoff, parts_first: parts_first > 0, given }
    }

    /// Takes a step on all processes, and sees that it was the same one.
    pub(super) fn step(&self, step: impl FnOnce() -> Result<StepReport, Fault>) -> Result<StepReport, Fault> {
        if self.processes.size() == 1 {
            return step();
        }
        if self.leads() {
            self.processes.tell(&[STEP]);
        }
        let stepped = step();
        let mut all = vec![0; self.processes.size()];
        self.processes.gather_even(&[digest(&stepped)], &mut all);
        match all.iter().position(|other| *other != all[0]) {
            Some(other) => Err(Fault::Processes(format!(
                "process {other} computed other numbers than rank 0: its processor or its mathematical library differs"
            ))),
            None => stepped,
        }
    }
}

/// A number that tells steps apart.
fn digest(stepped: &Result<StepReport, Fault>) -> u64 {
    let mut hasher = DefaultHasher::new();
    match stepped {
        Ok(report) => {
            let StepReport { step, bodies, constraints, iterations, products, max_overlap, residual, .. } = report;
            (step, bodies, constraints, iterations, products).hash(&mut hasher);
            [max_overlap, residual].map(|number| number.to_bits()).hash(&mut hasher);
        }
        Err(fault) => fault.to_string().hash(&mut hasher),
    }
    hasher.finish()
}

impl Simulation {
    /// Starts where rank 0 does, as it said, with what it gives.
    pub(crate) fn start_with_a_part(
        together: Together,
        scene: Scene,
        state: State,
        numbers: [u64; 4],
    ) -> Result<Self, Fault> {
        let none = vec![Vec::new(); together.processes.size()];
        let beginning = together.take_part(none, state, numbers);
        Simulation::begin(&Compute::Together(together), scene, beginning)
    }

    /// The processes that take it together, where there are several.
    pub fn processes(&self) -> Option<Processes> {
        self.together.map(|together| together.processes)
    }
}
