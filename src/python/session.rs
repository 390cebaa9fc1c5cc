//! A simulation with the totals of its run and its threads, for a Python object.

use super::compute::shared_threads_live;
use crate::dynamics::ForceField;
use crate::error::Error;
use crate::record::{RecordError, StateError, Totals, encode, scene_hash, write_state};
use crate::run::{RunStatus, Summary};
use crate::scene::Scene;
use crate::simulation::{CellValues, Change, ChangeError, Compute, Rules, Simulation};
use crate::step::{Fault, State, StepReport, max_overlap_but};
use rayon::ThreadPool;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// A simulation in progress.
pub(super) struct Session {
    simulation: Simulation,
    totals: Totals,
    scene_hash: String,
    threads: Threads,
}

/// The threads that compute a simulation, and their process; a fork lacks them.
pub(super) struct Threads {
    own: Option<ThreadPool>,
    process: u32,
}

impl Threads {
    pub fn new(own: Option<ThreadPool>) -> Self {
        Threads { own, process: std::process::id() }
    }

    /// Whether they exist in this process.
    fn live(&self) -> bool {
        self.process == std::process::id() && (self.own.is_some() || shared_threads_live())
    }

    /// Computes something on them.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.own {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

/// The end of a series of steps before the requested number.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The scene's end, or its `growth.stop`.
    OfScene,
    /// Only its `growth.stop`.
    OfGrowth,
    /// Nothing.
    None,
}

impl End {
    fn is_reached(self, simulation: &Simulation) -> bool {
        match self {
            End::OfScene => simulation.done(),
            End::OfGrowth => simulation.stopped_by().is_some(),
            End::None => false,
        }
    }
}

/// The result of a batch of steps.
pub(super) struct Batch {
    /// Steps taken.
    pub taken: u64,
    /// The last of them and its wall time.
    pub last: Option<(StepReport, Duration)>,
}

impl Session {
    /// Starts a scene from its own bodies.
    pub fn start(compute: &Compute, scene: Scene, threads: Threads) -> Result<Self, Error> {
        let begun = Instant::now();
        let hash = scene_hash(&scene);
        let (simulation, start_max_overlap) = threads.run(|| {
            let bodies = scene.build()?;
            let start_max_overlap = max_overlap_but(&scene.fixed(), &bodies, &scene.walls());
            Simulation::start(compute, scene, State::new(bodies)).map(|s| (s, start_max_overlap)).map_err(Error::from)
        })?;
        let mut totals = Totals { start_max_overlap, ..Totals::default() };
        totals.wall.setup = begun.elapsed().as_secs_f64();
        totals.wall.total = totals.wall.setup;
        totals.taken_up_by(&simulation);
        Ok(Session { simulation, totals, scene_hash: hash, threads })
    }

    /// Continues from a state and its totals.
    pub fn resume(
        compute: &Compute,
        scene: Scene,
        state: State,
        mut totals: Totals,
        threads: Threads,
    ) -> Result<Self, Fault> {
        let hash = scene_hash(&scene);
        let simulation = threads.run(|| Simulation::start(compute, scene, state))?;
        totals.taken_up_by(&simulation);
        Ok(Session { simulation, totals, scene_hash: hash, threads })
    }

    /// Whether its threads are in this process.
    pub fn live(&self) -> bool {
        self.threads.live()
    }

    /// Takes at least one step, then as many as fit into `wall`, at most `most`, and none past the end.
    pub fn advance(&mut self, most: u64, end: End, wall: Duration) -> (Batch, Result<(), Fault>) {
        let Session { simulation, totals, threads, .. } = self;
        threads.run(move || {
            let mut batch = Batch { taken: 0, last: None };
            let begun = Instant::now();
            while batch.taken < most && !end.is_reached(simulation) {
                let step_begun = Instant::now();
                let stepped = simulation.step();
                // There is no folder for saved LCPs.
                simulation.take_lcps();
                match stepped {
                    Ok(report) => {
                        let spent = step_begun.elapsed();
                        totals.add(&report, simulation.scene().contact.overlap_tolerance, spent);
                        (batch.taken, batch.last) = (batch.taken + 1, Some((report, spent)));
                    }
                    Err(fault) => return (batch, Err(fault)),
                }
                if begun.elapsed() >= wall {
                    break;
                }
            }
            (batch, Ok(()))
        })
    }

    /// Adds a force to those of the scene.
    pub fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.simulation.add_force(force);
    }

    /// Changes the state.
    pub fn change(&mut self, change: &Change) -> Result<Vec<u64>, ChangeError> {
        let Session { simulation, threads, .. } = self;
        threads.run(move || simulation.change(change))
    }

    /// Changes keys of the scene from now on.
    pub fn change_keys(&mut self, set: BTreeMap<String, Value>) -> Result<(), Error> {
        let Session { simulation, threads, .. } = self;
        threads.run(move || simulation.add_change(set))?;
        self.scene_hash = scene_hash(self.simulation.whole_scene());
        Ok(())
    }

    /// Sets the rules of the cells, or none.
    pub fn set_rules(&mut self, rules: Option<Box<dyn Rules>>) {
        match rules {
            Some(rules) => self.simulation.set_rules(rules),
            None => drop(self.simulation.take_rules()),
        }
    }

    /// What rules may change, as it is now.
    pub fn cell_values(&mut self) -> Result<CellValues, Fault> {
        self.simulation.cell_values()
    }

    /// The number of its own threads, if it has some.
    pub fn own_threads(&self) -> Option<usize> {
        self.threads.own.as_ref().map(ThreadPool::current_num_threads)
    }

    /// A checkpoint as bytes.
    pub fn encoded(&self) -> Result<Result<Vec<u8>, StateError>, Fault> {
        let state = self.simulation.state()?;
        Ok(encode(state, &self.scene_hash, self.simulation.time(), Some(&self.totals)))
    }

    /// The simulation.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Computes something from the simulation, on its threads.
    pub fn compute<T: Send>(&mut self, of: impl FnOnce(&Simulation) -> T + Send) -> T {
        let Session { simulation, threads, .. } = self;
        threads.run(move || of(simulation))
    }

    /// The summary of its run so far, like the program's `summary.json`.
    pub fn summary(&mut self) -> Result<Summary, Fault> {
        let Session { simulation, totals, scene_hash, threads } = self;
        let status = match (simulation.done(), totals.clean()) {
            (false, _) => RunStatus::Interrupted,
            (true, true) => RunStatus::Done,
            (true, false) => RunStatus::OutOfTolerance,
        };
        threads.run(move || {
            let overlap =
                max_overlap_but(&simulation.scene().fixed(), &simulation.state()?.bodies, &simulation.walls());
            Summary::new(simulation, totals, scene_hash, (status, None), overlap)
        })
    }

    /// Writes a checkpoint, atomically.
    pub fn save(&self, path: &Path) -> Result<Result<(), RecordError>, Fault> {
        let state = self.simulation.state()?;
        Ok(write_state(path, state, &self.scene_hash, self.simulation.time(), Some(&self.totals)))
    }
}
