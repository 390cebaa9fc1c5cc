//! A run that goes on from a state on the device has the bits of one that was not stopped.

use crate::device::{device, precisions};
use crate::friction::{bouncing_heap, heap_on_device};
use crate::long::precisions_of_long_runs;
use crate::steps::{crowd_of_superellipsoids, patch};
use glam::DVec3;
use relcp::gpu::{Gpu, Precision};
use relcp::record::Folder;
use relcp::run::{Run, RunStatus};
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::{State, Unrounded, UnroundedBody};
use std::sync::Arc;
use std::time::Duration;

/// What of two states differs first.
fn difference(a: &State, b: &State) -> Option<&'static str> {
    let numbers = |state: &State| state.unrounded.clone().unwrap_or_default();
    let (x, y): (Unrounded, Unrounded) = (numbers(a), numbers(b));
    let part =
        |same: fn(&UnroundedBody, &UnroundedBody) -> bool| !x.bodies.iter().zip(&y.bodies).all(|(x, y)| same(x, y));
    let found = [
        ("lineage", a.bodies.lineage != b.bodies.lineage),
        ("lengths", part(|x, y| x.length == y.length)),
        ("multipliers and normals", a.warm != b.warm),
        ("velocities", part(|x, y| (x.velocity, x.turning) == (y.velocity, y.turning))),
        ("orientations", part(|x, y| x.orientation == y.orientation)),
        ("positions", part(|x, y| (x.cell, x.remainder) == (y.cell, y.remainder))),
        ("anything else", a != b),
    ];
    found.iter().find(|(_, differs)| *differs).map(|(what, _)| *what)
}

/// Takes `count` steps, and from the state after each of `stops` the rest anew, in each precision.
fn goes_on(scene: &Scene, count: u64, stops: &[u64]) {
    let Some(gpu) = device() else { return };
    goes_on_in(gpu, &precisions(gpu), scene, count, stops);
}

/// The same of a long run.
fn goes_on_long(scene: &Scene, count: u64, stops: &[u64]) {
    let Some(gpu) = device() else { return };
    goes_on_in(gpu, &precisions_of_long_runs(gpu), scene, count, stops);
}

fn goes_on_in(gpu: &Arc<Gpu>, precisions: &[Precision], scene: &Scene, count: u64, stops: &[u64]) {
    for precision in precisions.iter().copied() {
        let compute = Compute::Gpu { gpu: gpu.clone(), precision };
        let mut whole = Simulation::builder(scene.clone()).on(&compute).build().unwrap();
        let mut states = vec![whole.state().unwrap().clone()];
        for _ in 0..count {
            whole.step().unwrap();
            states.push(whole.state().unwrap().clone());
        }
        for stop in stops {
            let from = states[*stop as usize].clone();
            let mut resumed = Simulation::builder(scene.clone()).on(&compute).resume(from).build().unwrap();
            for step in stop + 1..=count {
                resumed.step().unwrap();
                let found = difference(resumed.state().unwrap(), &states[step as usize]);
                assert_eq!(found, None, "{} {precision:?}: from step {stop}, after step {step}", scene.name);
            }
        }
        assert!(states[count as usize].warm.iter().any(|w| w.gamma > 0.0), "{}: nothing touched", scene.name);
    }
}

#[test]
fn superellipsoids_go_on_to_the_same_bits() {
    goes_on(&crowd_of_superellipsoids(), 30, &[7, 20]);
}

/// The device's own numbers count only where they are those of the bodies, and of that device.
/// The first part of a run is the device's, and the last the CPU's; `legs` name both.
#[test]
fn a_run_goes_on_on_another_machine_and_says_so() {
    let Some(gpu) = device() else { return };
    let place = tempfile::tempdir().unwrap();
    let (scene, folder) = (load("colony", &["time.end=4"]), Folder::create(&place.path().join("run")).unwrap());
    let on_device = Compute::Gpu { gpu: gpu.clone(), precision: Precision::F32 };
    let simulation = Simulation::builder(scene.clone()).on(&on_device).build().unwrap();
    let mut run = Run::start(simulation, folder.clone(), Duration::ZERO).unwrap();
    while run.simulation().bodies() < 20 {
        run.advance().unwrap();
    }
    let stopped = run.finish().unwrap();
    assert_eq!((stopped.status, stopped.backend), (RunStatus::Interrupted, "gpu"));
    let mut run = Run::resume(scene, Folder::open(folder.path()).unwrap(), &Compute::Cpu).unwrap();
    while !run.done() {
        run.advance().unwrap();
    }
    let summary = run.finish().unwrap();
    assert_eq!((summary.status, summary.backend), (RunStatus::Done, "cpu"));
    assert!(summary.final_max_overlap <= 1e-5);
    let [first, last] = &summary.legs[..] else { panic!("{:?}", summary.legs) };
    assert_eq!((first.machine.as_str(), first.precision.as_str(), first.from_step), ("gpu", "f32", 1));
    assert!(first.adapter.as_ref().is_some_and(|adapter| adapter.contains(gpu.name())));
    assert_eq!((last.machine.as_str(), last.adapter.as_ref(), last.from_step), ("cpu", None, stopped.steps + 1));
}

#[test]
fn bodies_that_were_changed_are_where_they_were_put() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let compute = Compute::Gpu { gpu: gpu.clone(), precision };
        let mut first = Simulation::builder(patch(2, DVec3::ZERO)).on(&compute).build().unwrap();
        first.step().unwrap();
        let mut state = first.state().unwrap().clone();
        state.bodies.position[3] += DVec3::new(100.0, 0.0, 0.0);
        let put = state.bodies.position[3];
        let mut changed = Simulation::builder(patch(2, DVec3::ZERO)).on(&compute).resume(state).build().unwrap();
        changed.step().unwrap();
        assert!((changed.state().unwrap().bodies.position[3] - put).length() < 1e-3);
        for other in precisions(gpu) {
            let compute = Compute::Gpu { gpu: gpu.clone(), precision: other };
            let from = first.state().unwrap().clone();
            let mut on_other = Simulation::builder(patch(2, DVec3::ZERO)).on(&compute).resume(from).build().unwrap();
            on_other.step().unwrap();
            let kind = on_other.state().unwrap().unrounded.as_ref().unwrap().kind;
            assert_eq!(kind[0], other.bytes() as f64);
        }
    }
}

fn load(name: &str, sets: &[&str]) -> Scene {
    Scene::load(name, sets).unwrap()
}

#[test]
fn crowded_rods() {
    goes_on(&patch(8, DVec3::new(3.3, -0.7, 0.0)), 30, &[5, 13, 29]);
}

#[test]
fn ellipsoids() {
    let sets = ["generate.0.isotropic.count=60", "generate.0.isotropic.volume_fraction=0.2", "time.end=20"];
    goes_on(&load("compaction", &sets), 80, &[7, 40, 61]);
}

#[test]
fn rings() {
    goes_on(&load("chainmail", &["time.dt=0.01"]), 60, &[11, 37]);
}

#[test]
fn a_growing_colony() {
    goes_on_long(&load("colony", &["time.dt=0.02", "time.end=5"]), 200, &[30, 101, 158]);
}

/// The mother is longer than cells at the start, so that another resolution of lengths would suit her.
#[test]
fn a_cell_that_is_about_to_divide() {
    goes_on(&load("colony", &["time.dt=0.02", "time.end=5"]), 74, &[70]);
}

#[test]
fn cells_that_feel_pressure_and_leave_a_channel() {
    let sets =
        ["time.dt=0.04", "time.end=6", "removal.0.outside.half_space.offset=-6", "growth.0.stress_sensitivity=0.1"];
    goes_on_long(&load("two-strains", &sets), 75, &[20, 51, 74]);
}

#[test]
fn a_periodic_cell_with_brownian_motion() {
    goes_on(&load("sedimentation", &["generate.0.isotropic.count=50", "periodic.lengths=[5, 5, null]"]), 30, &[9, 22]);
}

#[test]
fn heaps_that_keep_their_momentum() {
    let scene = r#"{"name": "heap", "seed": 4, "time": {"dt": 0.005, "end": 2}, "dynamics": {"inertial": {"density": 1}},
        "forces": [{"gravity": {"acceleration": [0, 0, -9.8]}}], "walls": [{"half_space": {"normal": [0, 0, 1], "offset": -1.5}}],
        "generate": [{"isotropic": {"count": 12, "shape": {"ellipsoid": {"radii": [0.3, 0.4, 0.5]}}, "volume_fraction": 0.15}}]}"#;
    goes_on_long(&Scene::parse(scene, "heap").unwrap(), 120, &[17, 60, 101]);
}

#[test]
fn a_heap_with_friction_and_restitution() {
    goes_on(&bouncing_heap(), 60, &[9, 41]);
    goes_on(&heap_on_device(60), 60, &[9, 41]);
}

#[test]
fn rough_cells_that_grow_and_divide() {
    let sets = ["time.dt=0.02", "time.end=5", "contact.friction=0.4"];
    goes_on_long(&load("colony", &sets), 140, &[30, 101]);
}

#[test]
fn midpoint_steps() {
    let sets = ["time.stepping=midpoint", "time.dt=0.02", "time.end=5"];
    goes_on_long(&load("colony", &sets), 180, &[30, 101, 158]);
    let sets = [
        "generate.0.isotropic.count=40",
        "generate.0.isotropic.volume_fraction=0.2",
        "time.stepping=midpoint",
        "time.end=20",
    ];
    goes_on_long(&load("compaction", &sets), 60, &[7, 40]);
}

#[test]
fn one_row_a_pair() {
    goes_on_long(&load("colony", &["time.dt=0.02", "time.end=5", "contact.rows=paper"]), 180, &[101, 158]);
}
