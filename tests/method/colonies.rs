//! Cells of different division lengths and rates, growth that pressure slows, and runs that stop before their end.

use crate::laws::{body, rod, start};
use crate::random::parse;
use glam::{DQuat, DVec3};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::dynamics::pressures;
use relcp::internals::backend::gpu::Device;
use relcp::internals::dynamics::{Cells, Species};
use relcp::measure::{Frame, Settings, View};
use relcp::record::{Folder, Snapshot};
use relcp::run::{Run, RunStatus};
use relcp::scene::{self, Growth, Scene, Stepping, StopReason};
use relcp::separation::Placed;
use relcp::shape::Shape;
use relcp::simulation::{Compute, Simulation};
use relcp::warm::Warm;
use serde_json::json;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Duration;

fn set(sets: &[&str]) -> Scene {
    Scene::load("colony", sets.iter().map(|set| set.to_string()).collect::<Vec<_>>()).unwrap()
}

/// A colony whose cells differ and feel pressure, to some twenty cells.
pub fn uneven(stepping: Stepping) -> Scene {
    let mut scene = set(&[
        "time.dt=0.01",
        "time.end=3.5",
        "growth.division_length_noise=0.2",
        "growth.rate_noise=0.3",
        "growth.stress_sensitivity=0.2",
        "growth.reorientation_degrees=5",
    ]);
    scene.time.stepping = stepping;
    scene
}

fn cells(seed: u64, noise: [f64; 2]) -> Cells {
    let [division_length_noise, rate_noise] = noise;
    let mut growth = Growth::new(0.5, 4.0);
    (growth.division_length_noise, growth.rate_noise) = (division_length_noise, rate_noise);
    Cells::new(&[growth], &[], true, seed)
}

/// The growth of the cells of a scene of one species.
fn of(cells: &Cells) -> Species<'_> {
    cells.of(NO_GROUP).unwrap()
}

#[test]
fn noise_is_uniform_about_the_mean_and_belongs_to_seed_and_cell() {
    let count = 20_000;
    let cells_of = cells(3, [0.25, 0.6]);
    let deviations: Vec<[f64; 2]> = (0..count)
        .map(|id| [of(&cells_of).target(id) / 4.0 - 1.0, of(&cells_of).rate(id, 0.0) / 0.5 - 1.0])
        .map(|[length, rate]| [length / 0.25, rate / 0.6])
        .collect();
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| deviations.iter().map(of).sum::<f64>() / count as f64;
    // Bounds of four standard deviations of the mean of so many draws: 1 / sqrt(3 n), sqrt(4 / 45 n), 1 / (3 sqrt(n)).
    let root = (count as f64).sqrt();
    for side in 0..2 {
        assert!(deviations.iter().all(|d| d[side].abs() <= 1.0 + 1e-12));
        assert!(mean(&|d| d[side]).abs() < 4.0 / (3f64.sqrt() * root));
        assert!((mean(&|d| d[side] * d[side]) - 1.0 / 3.0).abs() < 4.0 * (4.0 / 45.0f64).sqrt() / root);
        assert!(deviations.iter().map(|d| d[side]).fold(0.0, f64::max) > 0.999);
    }
    assert!(mean(&|d| d[0] * d[1]).abs() < 4.0 / (3.0 * root), "length and rate go together");
    let along = deviations.windows(2).map(|pair| pair[0][0] * pair[1][0]).sum::<f64>() / count as f64;
    assert!(along.abs() < 4.0 / (3.0 * root), "neighbouring cells go together");

    // One noise does not shift the other, and another seed gives other draws.
    assert_eq!(of(&cells(3, [0.25, 0.0])).target(17), of(&cells_of).target(17));
    assert_eq!(of(&cells(3, [0.0, 0.6])).rate(17, 0.0), of(&cells_of).rate(17, 0.0));
    assert_eq!((of(&cells(3, [0.0; 2])).target(17), of(&cells(3, [0.0; 2])).rate(17, 0.0)), (4.0, 0.5));
    assert_ne!(of(&cells(4, [0.25, 0.6])).rate(17, 0.0), of(&cells_of).rate(17, 0.0));
}

#[test]
fn each_cell_grows_at_its_rate_and_divides_at_its_length() {
    let scene = set(&[
        "time.dt=0.02",
        "time.end=4",
        "growth.division_length_noise=0.2",
        "growth.rate_noise=0.3",
        "growth.reorientation_degrees=5",
    ]);
    let (cells, dt) = (scene.cells().unwrap(), scene.time.dt);
    let mut simulation = start(scene);
    let lengths = |simulation: &Simulation| -> HashMap<u64, f64> {
        let bodies = &simulation.state().unwrap().bodies;
        bodies.lineage.iter().zip(&bodies.shape).map(|(l, s)| (l.id, s.growing_length().unwrap())).collect()
    };
    let (mut divisions, mut at) = (0, Vec::new());
    while !simulation.done() {
        let before = lengths(&simulation);
        simulation.step().unwrap();
        let state = simulation.state().unwrap();
        let after = lengths(&simulation);
        for line in &state.bodies.lineage {
            let growth = (of(&cells).rate(line.id, 0.0) * dt).exp();
            let started = before.get(&line.id).copied().unwrap_or_else(|| 0.5 * before[&line.parent.unwrap()]);
            assert!((after[&line.id] / (started * growth) - 1.0).abs() < 1e-14);
        }
        for (id, length) in &before {
            let due = *length >= of(&cells).target(*id);
            assert_eq!(due, !after.contains_key(id), "cell {id} of length {length}");
            divisions += usize::from(due);
            at.extend(due.then_some(*length));
        }
    }
    println!("{divisions} divisions at {at:.2?}");
    assert!(divisions > 15 && simulation.bodies() == divisions + 1);
    let [least, most] = [at.iter().copied().fold(f64::INFINITY, f64::min), at.iter().copied().fold(0.0, f64::max)];
    assert!(least > 3.2 && least < 3.8 && most > 4.2 && most < 4.8 * (1.3f64 * 0.02).exp(), "{least} {most}");
}

#[test]
fn pressure_is_force_times_lever_over_volume() {
    let shape = Shape::Spherocylinder { diameter: 0.5, length: 2.5 };
    let along = DQuat::from_rotation_y(FRAC_PI_2);
    let mut bodies = Bodies::default();
    // Side by side, crosswise in space, and alone.
    for (position, orientation) in
        [(DVec3::ZERO, along), (DVec3::Y * 0.5, along), (DVec3::new(0.0, 0.0, 0.5), along), (DVec3::X * 9.0, along)]
    {
        bodies.push(Placed { shape, position, orientation }, NO_GROUP);
    }
    let warm = |pair: [u32; 2], gamma: f64| Warm { pair, feature: 0, gamma, normal: DVec3::ZERO, tangent: DVec3::ZERO };
    let area = 2.0 * 0.5 + PI * 0.0625;
    let planar = pressures(&bodies, &[warm([0, 1], 3.0)], true);
    let expected = 3.0 * 0.25 / (2.0 * area);
    assert!((planar[0] / expected - 1.0).abs() < 1e-14 && (planar[1] / expected - 1.0).abs() < 1e-14, "{planar:?}");
    assert_eq!(planar[2..], [0.0, 0.0]);
    let volume = PI * 0.0625 * 2.0 + PI / 6.0 * 0.125;
    let space = pressures(&bodies, &[warm([0, 1], 3.0), warm([0, 2], 5.0), warm([1, 2], 0.0)], false);
    let expected = [8.0, 3.0, 5.0, 0.0].map(|force| force * 0.25 / (3.0 * volume));
    assert!(space.iter().zip(expected).all(|(p, e)| (p - e).abs() < 1e-14), "{space:?} {expected:?}");
}

#[test]
fn growth_slows_under_the_pressure_that_is_measured() {
    let scene = uneven(Stepping::Euler);
    let (cells, dt) = (scene.cells().unwrap(), scene.time.dt);
    let frame = Frame::of_scene(&scene, "colony".into());
    let mut simulation = start(scene);
    let (mut slowest, mut compared) = (1.0f64, 0);
    while !simulation.done() {
        let state = simulation.state().unwrap();
        let (bodies, warm) = (state.bodies.clone(), state.warm.clone());
        let (step, time) = (state.step, simulation.time());
        let felt = pressures(&bodies, &warm, true);
        if step > 0 {
            let (snapshot, settings) = (
                Snapshot {
                    step,
                    time,
                    bodies: bodies.clone(),
                    warm: Some(warm),
                    removed: Vec::new(),
                    fields: Vec::new(),
                },
                Settings::default(),
            );
            let view = View::new(&snapshot, &frame, &settings);
            let measured = view.virials().unwrap();
            for ((felt, virial), area) in felt.iter().zip(measured).zip(&view.volumes) {
                assert!((felt - virial / (2.0 * area)).abs() <= 1e-12 * felt.abs().max(1.0));
            }
        }
        simulation.step().unwrap();
        let after = &simulation.state().unwrap().bodies;
        for (i, felt) in felt.iter().enumerate() {
            let line = bodies.lineage[i];
            if after.lineage[i].id == line.id {
                let own = of(&cells).rate(line.id, 0.0);
                let expected = (own * (-0.2 * felt).exp() * dt).exp();
                let grown = after.shape[i].growing_length().unwrap() / bodies.shape[i].growing_length().unwrap();
                assert!((grown - expected).abs() < 1e-14);
                slowest = slowest.min(grown.ln() / (own * dt));
                compared += 1;
            }
        }
    }
    println!("{compared} growths, the slowest at {slowest:.3} of its rate, {} cells", simulation.bodies());
    assert!(slowest < 0.8 && compared > 1000);
}

/// Steps a run from its folder's checkpoint to its end.
fn finish(mut run: Run) -> Simulation {
    while !run.done() {
        run.advance().unwrap();
    }
    let (scene, state) = (run.simulation().scene().clone(), run.simulation().state().unwrap().clone());
    run.finish().unwrap();
    Simulation::builder(scene).resume(state).build().unwrap()
}

#[test]
fn a_checkpoint_keeps_what_growth_needs() {
    for stepping in [Stepping::Euler, Stepping::Midpoint] {
        let parent = tempfile::tempdir().unwrap();
        let run = |name| {
            let folder = Folder::create_in(parent.path(), name).unwrap();
            Run::start(start(uneven(stepping)), folder, Duration::ZERO).unwrap()
        };
        let whole = finish(run("whole"));
        let mut broken = run("broken");
        while broken.simulation().steps() < 230 {
            broken.advance().unwrap();
        }
        broken.checkpoint().unwrap();
        let folder = broken.folder().clone();
        drop(broken);
        let resumed = finish(Run::resume(uneven(stepping), folder, &Compute::Cpu).unwrap());
        assert!(resumed.state().unwrap() == whole.state().unwrap());
        assert!(whole.state().unwrap().warm.iter().any(|warm| warm.gamma > 0.0));
    }
}

#[test]
fn a_run_stops_at_a_population_a_time_or_a_radius() {
    let base =
        ["time.dt=0.02", "growth.reorientation_degrees=5", "growth.division_length_noise=0.1", "output.every=0.5"];
    for (stop, reason) in [
        ("growth.stop.population=11", StopReason::Population),
        ("growth.stop.time=1.01", StopReason::Time),
        ("growth.stop.radius=5", StopReason::Radius),
        (r#"growth.stop={"radius": 50, "time": 3, "population": 5}"#, StopReason::Population),
    ] {
        let scene = set(&[&base[..], &[stop, "output.step_stride=7"]].concat());
        let mut simulation = start(scene.clone());
        let mut before = (0, 0.0, 0.0);
        let outermost = |simulation: &Simulation| {
            let state = simulation.state().unwrap();
            let snapshot = Snapshot {
                step: state.step,
                time: 0.0,
                bodies: state.bodies.clone(),
                warm: None,
                removed: Vec::new(),
                fields: Vec::new(),
            };
            let states = relcp::record::States::single("state", snapshot);
            let radius = relcp::measure::select(&["radius".into()]).unwrap();
            let measured =
                relcp::measure::measure("three-capsules", &states, &radius, &Settings::default(), &mut |_, _| true);
            measured.unwrap().value(0, "radius_outermost").unwrap()
        };
        while !simulation.done() {
            before = (simulation.bodies(), simulation.time(), outermost(&simulation));
            simulation.step().unwrap();
        }
        assert_eq!(simulation.stopped_by(), Some(reason), "{stop}");
        let after = (simulation.bodies(), simulation.time(), outermost(&simulation));
        let wanted = scene.stop().unwrap();
        match reason {
            StopReason::Population => {
                let least = wanted.population.unwrap() as usize;
                assert!(before.0 < least && after.0 >= least);
            }
            StopReason::Time => assert!(before.1 < 1.01 && after.1 >= 1.01),
            StopReason::Radius => assert!(before.2 < 5.0 && after.2 >= 5.0, "{before:?} {after:?}"),
            other => panic!("{other:?}"),
        }
        // The folder of such a run has its last state and row, and stays as it is when it is resumed.
        let parent = tempfile::tempdir().unwrap();
        let folder = Folder::create_in(parent.path(), "run").unwrap();
        let mut run = Run::start(start(scene.clone()), folder.clone(), Duration::ZERO).unwrap();
        while !run.done() {
            run.advance().unwrap();
        }
        let summary = run.finish().unwrap();
        assert_eq!((summary.status, summary.completed, summary.stopped_by), (RunStatus::Done, true, Some(reason)));
        assert_eq!(summary.steps, simulation.steps());
        assert!(folder.state(summary.steps).is_file() && folder.last().is_file());
        let rows = std::fs::read_to_string(folder.steps()).unwrap();
        assert!(rows.trim_end().lines().last().unwrap().starts_with(&format!("{},", summary.steps)));
        let again = Run::resume(scene.clone(), folder.clone(), &Compute::Cpu).unwrap();
        assert!(again.done());
        assert_eq!(again.finish().unwrap().stopped_by, Some(reason));
        assert_eq!(std::fs::read_to_string(folder.steps()).unwrap(), rows);
        // What it ended with can be gone on with as a scene.
        assert!(Scene::read(folder.last()).is_ok());
    }
    let mut whole = start(set(&["time.dt=0.02", "time.end=0.1", "growth.stop.population=100"]));
    while !whole.done() {
        whole.step().unwrap();
    }
    assert_eq!((whole.stopped_by(), whole.steps()), (None, 5));
}

#[test]
fn a_stop_bounds_the_population_that_a_scene_may_ask_for() {
    let long = ["time.end=30".to_owned(), "growth.stop.population=1000".into()];
    assert!(Scene::load("colony", &long[..1]).is_err());
    assert!(Scene::load("colony", &long).is_ok());
    assert!(Scene::load("colony", ["time.end=30", "growth.stop.radius=10"]).is_err());
}

#[test]
fn a_device_refuses_what_only_the_cpu_does_before_the_run() {
    for stepping in [Stepping::Euler, Stepping::Midpoint] {
        assert!(Device::check(&uneven(stepping).model()).is_ok());
    }
    let mut scene = uneven(Stepping::Midpoint);
    scene.contact.method = serde_json::from_value(json!({"multisphere": {"count": 7}})).unwrap();
    let refused = Device::check(&scene.model()).unwrap_err().to_string();
    assert!(refused.contains("multi-sphere rows"), "{refused}");
}

#[test]
fn what_is_not_asked_for_is_not_written() {
    let plain = parse(&json!({
        "name": "cell", "time": {"dt": 0.01, "end": 1}, "growth": {"rate": 1.0, "division_length": 4.0},
        "bodies": [body(rod(0.5, 2.0), [0.0; 3], DQuat::from_rotation_y(FRAC_PI_2))]
    }));
    let written = serde_json::to_value(&plain).unwrap();
    let keys: Vec<&String> = written["growth"].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["division_length", "rate", "reorientation_degrees"]);
    let schema = serde_json::to_string(&scene::schema()).unwrap();
    for key in ["division_length_noise", "rate_noise", "stress_sensitivity", "population"] {
        assert!(schema.contains(key), "{key}");
    }
}
