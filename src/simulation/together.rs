//! A simulation that several processes take together: process 0 leads, the others do what it says.
//!
//! All of them have the same scene and bodies and take the same steps. What they share is inside of a step, and what a
//! step leaves of pairs, which process 0 gathers when it is asked for the state.

use super::Simulation;
use crate::processes::Processes;
use crate::scene::Scene;
use crate::step::{Fault, State, StepReport};
use std::hash::{DefaultHasher, Hash, Hasher};

/// What process 0 says, as the first byte of a message.
const END: u8 = 0;
const START: u8 = 1;
const STEP: u8 = 2;
const GATHER: u8 = 3;

/// A scene and a state in a message.
pub type Pack = fn(&Scene, &State) -> Result<Vec<u8>, String>;

/// How processes take a simulation together.
#[derive(Clone, Copy)]
pub struct Together {
    processes: Processes,
    pack: Pack,
}

/// What process 0 said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    /// There is nothing more to do.
    End,
    /// A scene and a state to start from, as packed.
    Start(Vec<u8>),
    /// To take a step.
    Step,
    /// To give what is remembered of pairs.
    Gather,
}

impl Together {
    /// Of these processes; `pack` puts what process 0 starts from in a message for the others.
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

    /// Waits for what process 0 says.
    pub fn hear(&self) -> Said {
        let mut message = self.processes.hear();
        match message.first() {
            Some(&START) => Said::Start(message.split_off(1)),
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

    /// Has the others start from where process 0 does.
    pub(super) fn start(&self, scene: &Scene, state: &State) -> Result<(), Fault> {
        if self.leads() && self.processes.size() > 1 {
            let packed = (self.pack)(scene, state).map_err(Fault::Processes)?;
            self.processes.tell(&[&[START], packed.as_slice()].concat());
        }
        Ok(())
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
                "process {other} computed other numbers than process 0: its processor or its mathematical library differs"
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
    /// The processes that take it together, where there are several.
    pub fn processes(&self) -> Option<Processes> {
        self.together.map(|together| together.processes)
    }
}
