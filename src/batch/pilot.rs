//! A pilot of a sweep: whether the processor or a device takes it in less time, measured on its first member.
//!
//! Scenes that grow are small at their start, where a device has nothing to do. So the processor first takes the member
//! as far as it gets in some seconds; from a state of the second half of that way both are timed.

use crate::error::Error;
use crate::gpu::{Gpu, Precision};
use crate::scene::Scene;
use crate::simulation::{Compute, Simulation};
use crate::step::State;
use std::fmt;
use std::sync::{Arc, Barrier};
use std::time::{Duration, Instant};

/// How long the processor goes on at most: little beside a sweep that is worth a device.
const LONGEST_WAY: Duration = Duration::from_secs(3);

/// Steps that are timed, and steps before them, in which lists are made and kernels compiled.
const STEPS: u32 = 16;
const WARM_UP: u32 = 2;

/// The device is taken where it takes at most this part of the processor's time: members that differ share fewer
/// dispatches than the pilot's, which are all alike.
const PAYS: f64 = 0.7;

/// Gives a device to one more scene.
pub type Devices<'a> = dyn Fn() -> Arc<Gpu> + Sync + 'a;

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pilot {
    /// Bodies of the state that the steps were timed from.
    pub bodies: usize,
    /// Members that the device computed at once.
    pub members: usize,
    /// Threads that share so many members on the processor.
    pub threads: usize,
    /// Seconds for a step of all members: on the processor, each on one thread.
    pub cpu: f64,
    /// The same on the device.
    pub device: f64,
}

impl Pilot {
    /// Times a step of so many copies of a scene on devices, one for each copy, and on so many threads. `device` gives
    /// the next copy's, as [`Ensemble::member`](crate::gpu::Ensemble::member) does.
    ///
    /// # Errors
    /// What [`SimulationBuilder::build`](crate::simulation::SimulationBuilder::build) refuses, and faults of steps.
    pub fn run(
        scene: &Scene,
        (device, precision): (&Devices, Precision),
        members: usize,
        threads: usize,
    ) -> Result<Pilot, Error> {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let on_processor = || {
            let state = way(scene)?;
            let mut simulation = Simulation::builder(scene.clone()).resume(state.clone()).build()?;
            Ok::<_, Error>((state, take(&mut simulation)?))
        };
        let (state, alone) = match alone {
            Ok(pool) => pool.install(on_processor),
            // Without a thread of its own it takes this one.
            Err(_) => on_processor(),
        }?;
        let device = together(scene, &state, (device, precision), members)?;
        let rounds = members.div_ceil(threads.max(1));
        Ok(Pilot { bodies: state.bodies.len(), members, threads, cpu: alone * rounds as f64, device })
    }

    /// Whether the device takes clearly less time.
    pub fn device_is_faster(&self) -> bool {
        self.device <= PAYS * self.cpu
    }
}

impl fmt::Display for Pilot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Pilot { bodies, members, threads, cpu, device } = self;
        let [cpu, device] = [cpu, device].map(|seconds| 1e3 * seconds);
        write!(
            f,
            "a step of {members} members of {bodies} bodies takes {device:.3} ms on the device, {cpu:.3} ms on the CPU \
             with {threads} threads"
        )
    }
}

/// A state of the second half of the way that the processor gets.
fn way(scene: &Scene) -> Result<State, Error> {
    let mut simulation = Simulation::new(scene.clone())?;
    let mut state = simulation.state()?.clone();
    let (begun, mut next) = (Instant::now(), 2 * (simulation.steps() + 1));
    while simulation.steps() < scene.time.steps() && simulation.stopped_by().is_none() && begun.elapsed() < LONGEST_WAY
    {
        // A member that fails there is timed before.
        if simulation.step().is_err() {
            break;
        }
        if simulation.steps() >= next {
            state.clone_from(simulation.state()?);
            next *= 2;
        }
    }
    Ok(state)
}

/// Takes the steps that are not timed, and those that are. Returns the seconds of one.
fn take(simulation: &mut Simulation) -> Result<f64, Error> {
    for _ in 0..WARM_UP {
        simulation.step()?;
    }
    let begun = Instant::now();
    for _ in 0..STEPS {
        simulation.step()?;
    }
    Ok(begun.elapsed().as_secs_f64() / f64::from(STEPS))
}

/// Seconds of a step of all members on the device.
fn together(
    scene: &Scene,
    state: &State,
    (device, precision): (&Devices, Precision),
    members: usize,
) -> Result<f64, Error> {
    let ready = Barrier::new(members);
    let member = || {
        let gpu = device();
        let built =
            Simulation::builder(scene.clone()).resume(state.clone()).on(&Compute::Gpu { gpu, precision }).build();
        // One that could not be built must not hold up the others.
        ready.wait();
        take(&mut built?)
    };
    let times = std::thread::scope(|scope| {
        let running: Vec<_> = (0..members).map(|_| scope.spawn(member)).collect();
        // One that panicked says nothing for the device.
        let ended = |thread: std::thread::ScopedJoinHandle<'_, _>| thread.join().unwrap_or(Ok(f64::INFINITY));
        running.into_iter().map(ended).collect::<Vec<Result<f64, Error>>>()
    });
    times.into_iter().try_fold(0.0_f64, |longest, time| Ok(longest.max(time?)))
}
