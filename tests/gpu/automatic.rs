//! Runs that are handed over between the CPU and a device, which here is a software adapter that counts as hardware.
//! What the machines cost is played, so that what is chosen does not depend on this machine's pace.

use crate::device::device;
use relcp::dynamics::Load;
use relcp::gpu::{Choice, Precision};
use relcp::internals::simulation::{Clock, Settings};
use relcp::record::{Folder, state_hash};
use relcp::run::{Run, RunStatus};
use relcp::simulation::{Automatic, Compute, Leg, Machine, Reason, Simulation};
use relcp::step::{contacts, max_overlap};
use relcp::{Bodies, Scene};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Trials as soon as there are eight cells, whatever they cost.
const SOON: Settings = Settings {
    least_bodies: 8,
    allowed_loss: 10.0,
    opening: 0.0,
    warm_up: 1,
    trial_steps: 3,
    reference_steps: 4,
    pays: 0.9,
};

fn choice() -> Choice {
    Choice { name: std::env::var("RELCP_ADAPTER").ok(), software: true, ..Choice::default() }
}

/// Time passes where someone looks at the clock: a second on the CPU, and on the device a tenth of it, from its look
/// number `slow_from` on ten seconds.
fn clock(slow_from: u64) -> Clock {
    let (looks, seconds) = (AtomicU64::new(0), Mutex::new(0.0));
    Arc::new(move |machine| {
        let mut seconds = seconds.lock().unwrap_or_else(PoisonError::into_inner);
        *seconds += match machine {
            Machine::Cpu => 1.0,
            Machine::Gpu if looks.fetch_add(1, Ordering::Relaxed) < slow_from => 0.1,
            Machine::Gpu => 10.0,
        };
        *seconds
    })
}

fn automatic(slow_from: u64) -> Compute {
    Compute::Auto(Automatic::new(choice(), Some(Precision::F32)).with(SOON, Some(clock(slow_from))))
}

fn colony(end: f64) -> Scene {
    Scene::load("colony", [format!("time.end={end}")]).unwrap()
}

fn deepest(bodies: &Bodies, scene: &Scene) -> f64 {
    let deepest = contacts(bodies, 0.0).iter().map(|contact| -contact.separation).fold(0.0, f64::max);
    assert_eq!(deepest, max_overlap(bodies, &scene.walls()));
    deepest
}

fn changes(legs: &[Leg]) -> Vec<(Machine, Reason)> {
    legs.iter().map(|leg| (leg.machine, leg.reason)).collect()
}

#[test]
fn a_colony_is_handed_over_and_back_without_overlaps() {
    if device().is_none() {
        return;
    }
    let scene = colony(4.6);
    let mut simulation = Simulation::builder(scene.clone()).on(&automatic(300)).build().unwrap();
    let mut on_device = 0;
    while !simulation.done() {
        let report = simulation.step().unwrap();
        on_device += u64::from(simulation.machine() == Machine::Gpu);
        assert!(report.max_overlap <= 1e-5, "{report:?}");
        assert_eq!(report.step, simulation.steps());
    }
    let legs = simulation.legs();
    legs.iter().for_each(|leg| println!("{leg}"));
    let [cpu, gpu] = [Machine::Cpu, Machine::Gpu];
    let first = [
        (cpu, Reason::Begins),
        (gpu, Reason::FirstTrial),
        (gpu, Reason::Faster),
        (cpu, Reason::OtherWasFaster),
        (cpu, Reason::Faster),
        (gpu, Reason::MoreBodies),
        (cpu, Reason::NotSlower),
    ];
    assert_eq!(changes(legs)[..first.len()], first);
    assert!(on_device > 100 && legs[1].adapter.is_some() && legs[1].precision == "f32");
    assert!(legs.is_sorted_by_key(|leg| leg.from_step));
    let bodies = &simulation.state().unwrap().bodies;
    assert!(deepest(bodies, &scene) <= 1e-5);
    let mut alone = Simulation::new(scene).unwrap();
    while !alone.done() {
        alone.step().unwrap();
    }
    assert_eq!(bodies.lineage, alone.state().unwrap().bodies.lineage);
}

#[test]
fn a_run_is_resumed_after_it_was_handed_over() {
    if device().is_none() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let (scene, folder) = (colony(4.0), Folder::create(&place.path().join("run")).unwrap());
    let simulation = Simulation::builder(scene.clone()).on(&automatic(u64::MAX)).build().unwrap();
    let mut run = Run::start(simulation, folder.clone(), Duration::ZERO).unwrap();
    while run.simulation().bodies() < 20 {
        run.advance().unwrap();
    }
    assert_eq!(run.simulation().machine(), Machine::Gpu);
    assert_eq!(run.totals().legs, run.simulation().legs());
    let stopped = run.finish().unwrap();
    assert_eq!((stopped.status, stopped.backend), (RunStatus::Interrupted, "gpu"));
    for (compute, last) in [(automatic(u64::MAX), Machine::Gpu), (Compute::Cpu, Machine::Cpu)] {
        let copy = place.path().join(last.name());
        std::fs::create_dir(&copy).unwrap();
        copy_all(folder.path(), &copy);
        let mut run = Run::resume(scene.clone(), Folder::open(&copy).unwrap(), &compute).unwrap();
        while !run.done() {
            run.advance().unwrap();
        }
        let summary = run.finish().unwrap();
        assert_eq!((summary.status, summary.backend), (RunStatus::Done, last.name()));
        assert!(summary.final_max_overlap <= 1e-5);
        let (earlier, later) = summary.legs.split_at(stopped.legs.len());
        assert_eq!(earlier, stopped.legs);
        assert_eq!((later[0].machine, later[0].from_step), (Machine::Cpu, stopped.steps + 1));
        assert_eq!(later.last().unwrap().machine, last);
        assert!(summary.legs.is_sorted_by_key(|leg| leg.lost_seconds), "{:?}", summary.legs);
    }
}

/// Copies a folder with its folders.
fn copy_all(from: &std::path::Path, to: &std::path::Path) {
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            std::fs::create_dir(&target).unwrap();
            copy_all(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
fn a_users_own_force_goes_with_the_state() {
    if device().is_none() {
        return;
    }
    let mut simulation = Simulation::builder(colony(4.6)).on(&automatic(300)).build().unwrap();
    let calls = Arc::new(AtomicUsize::new(0));
    let counter = calls.clone();
    simulation.add_force(Box::new(move |_: &Bodies, _: usize, _: f64| {
        counter.fetch_add(1, Ordering::Relaxed);
        Load::default()
    }));
    while !simulation.done() {
        let (before, bodies) = (calls.load(Ordering::Relaxed), simulation.bodies());
        simulation.step().unwrap();
        let called = calls.load(Ordering::Relaxed) - before;
        assert!(called >= bodies, "{called} calls for {bodies} bodies on the {:?}", simulation.machine());
        assert!(called <= 2 * simulation.bodies(), "{called} calls on the {:?}", simulation.machine());
    }
    assert!(changes(simulation.legs()).contains(&(Machine::Cpu, Reason::Faster)));
}

#[test]
fn without_a_device_that_fits_the_bits_are_the_cpus() {
    let none = Choice { name: Some("no-such-adapter".into()), ..Choice::default() };
    let compute = Compute::Auto(Automatic::new(none, None).with(SOON, Some(clock(0))));
    let [ours, cpu] = [compute, Compute::Cpu].map(|compute| {
        let mut simulation = Simulation::builder(colony(3.0)).on(&compute).build().unwrap();
        while !simulation.done() {
            simulation.step().unwrap();
        }
        (state_hash(simulation.state().unwrap()), simulation.legs().len())
    });
    assert_eq!(ours, cpu);
}

#[test]
fn what_a_device_cannot_do_stays_on_the_cpu_and_is_named() {
    let scene = Scene::load("colony", ["solver.kind=dense", "time.end=0.1"]).unwrap();
    let simulation = Simulation::builder(scene).on(&automatic(0)).build().unwrap();
    let [leg] = simulation.legs() else { panic!("{:?}", simulation.legs()) };
    assert_eq!((leg.machine, leg.reason), (Machine::Cpu, Reason::Begins));
    assert!(leg.message.as_deref().unwrap().contains("dense"), "{leg}");
}
