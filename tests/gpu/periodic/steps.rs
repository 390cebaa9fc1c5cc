//! Steps in periodic space on the device: the CPU's, held to the tolerance through boundaries, wherever the cell is.

use crate::device::{device, precisions};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::gpu::{Gpu, Precision};
use relcp::periodic::Periods;
use relcp::record::state_hash;
use relcp::scene::{self, Recursion, Scene};
use relcp::shape::Shape;
use relcp::simulation::{Compute, Simulation};
use relcp::step::{Fault, State, StepReport, contacts};
use std::sync::Arc;

fn compute(gpu: &Arc<Gpu>, precision: Precision) -> Compute {
    Compute::Gpu { gpu: gpu.clone(), precision }
}

/// Bodies in a small cell, of two groups that are driven through each other.
fn suspension(planar: bool, lengths: &str, rules: &str, more: &str, end: f64) -> Scene {
    let text = format!(
        r#"{{"name": "suspension", "seed": 11, "planar": {planar}, "time": {{"dt": 0.05, "end": {end}}}, "periodic": {{"lengths": {lengths}}}, {more}
        "forces": [{{"uniform": {{"force": [3.0, 1.0, 0.0], "group": "up"}}}}, {{"uniform": {{"force": [-3.0, 0.5, 0.0], "group": "down"}}}}],
        "generate": [{rules}]}}"#
    );
    Scene::parse(&text, "suspension").unwrap()
}

fn rule(group: &str, count: usize, shape: &str, fraction: f64) -> String {
    format!(
        r#"{{"isotropic": {{"count": {count}, "shape": {shape}, "volume_fraction": {fraction}, "group": "{group}"}}}}"#
    )
}

fn both_groups(shape: &str, fraction: f64) -> String {
    ["up", "down"].map(|group| rule(group, 15, shape, fraction)).join(", ")
}

const ELLIPSOID: &str = r#"{"ellipsoid": {"radii": [0.8, 1.0, 1.9]}}"#;
const ROD: &str = r#"{"spherocylinder": {"diameter": 1.0, "length": 4.0}}"#;

fn ellipsoids() -> Scene {
    suspension(false, "[9.5, 10.0, 10.5]", &both_groups(ELLIPSOID, 0.0957), "", 2.0)
}

/// Bodies on a lattice that fills the cell, turned anyhow; each is driven against the one beside it, some through the
/// boundary.
fn in_the_plane(shape: Shape) -> Scene {
    let sphere = r#"{"sphere": {"radius": 0.5}}"#;
    let mut scene = suspension(
        true,
        "[18.0, 17.0, null]",
        &["up", "down"].map(|group| rule(group, 1, sphere, 0.002567)).join(", "),
        "",
        2.0,
    );
    scene.generate.clear();
    for i in 0..30 {
        let turn = DQuat::from_rotation_z(2.4 * f64::from(i)) * DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let mut body = scene::Body::new(shape, [3.0 * f64::from(i % 6) - 0.1, 3.4 * f64::from(i / 6), 0.0]);
        body.orientation = Some([turn.w, turn.x, turn.y, turn.z]);
        body.group = Some(["down", "up"][i as usize % 2].into());
        scene.bodies.push(body);
    }
    scene
}

fn planar_rods() -> Scene {
    in_the_plane(Shape::Spherocylinder { diameter: 0.9, length: 2.9 })
}

struct Ran {
    state: State,
    reports: Vec<StepReport>,
}

impl Ran {
    fn from(compute: &Compute, scene: &Scene, bodies: Bodies) -> Ran {
        let mut simulation = Simulation::builder(scene.clone()).bodies(bodies).on(compute).build().unwrap();
        let mut reports = Vec::new();
        while !simulation.done() {
            reports.push(simulation.step().unwrap());
        }
        Ran { state: simulation.state().unwrap().clone(), reports }
    }

    fn of(compute: &Compute, scene: &Scene) -> Ran {
        Ran::from(compute, scene, scene.build().unwrap())
    }

    fn worst(&self) -> f64 {
        self.reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max)
    }

    /// The largest overlap of the final state, of every image, in f64 on the CPU.
    fn audited(&self) -> f64 {
        contacts(&self.state.bodies, 0.0).iter().map(|contact| -contact.separation).fold(0.0, f64::max)
    }

    /// Contacts through a boundary, near or overlapping.
    fn through(&self) -> usize {
        let mut open = self.state.bodies.clone();
        open.periods = Periods::NONE;
        contacts(&self.state.bodies, 0.05).len() - contacts(&open, 0.05).len()
    }

    fn crossed(&self, start: &Bodies) -> usize {
        let bodies = &self.state.bodies;
        let cell = |x: DVec3| bodies.periods.wrapped(x).1;
        (0..bodies.len().min(start.len())).filter(|i| cell(bodies.position[*i]) != cell(start.position[*i])).count()
    }
}

/// The farthest that two states' bodies are apart, whatever cells they are in, after `by` is taken off the second.
fn farthest(a: &Bodies, b: &Bodies, by: DVec3) -> f64 {
    let apart = |i: usize| {
        let [p, q] = [a.orientation[i], b.orientation[i]];
        let turned = (p - q).length().min((p + q).length());
        a.periods.nearest(b.position[i] - by - a.position[i]).length().max(turned)
    };
    (0..a.len()).map(apart).fold(0.0, f64::max)
}

/// Holds the device to the CPU's recursions and bounds, and in f64 to its places.
fn follows_the_cpu(scene: &Scene, f32_bound: f64, f64_bound: f64) {
    let Some(gpu) = device() else { return };
    let start = scene.build().unwrap();
    let cpu = Ran::of(&Compute::Cpu, scene);
    let rows = cpu.reports.iter().map(|r| r.constraints).max().unwrap();
    let crossed = cpu.crossed(&start);
    let through = cpu.through();
    assert!(
        rows >= 10 && crossed >= 3 && through >= 1,
        "{rows} rows, {crossed} bodies have crossed, {through} contacts"
    );
    for precision in precisions(gpu) {
        let ran = Ran::of(&compute(gpu, precision), scene);
        let same = ran.reports.iter().zip(&cpu.reports).filter(|(a, b)| a.recursions == b.recursions).count();
        let part = same as f64 / cpu.reports.len() as f64;
        let off = farthest(&cpu.state.bodies, &ran.state.bodies, DVec3::ZERO);
        let (worst, audited) = (ran.worst(), ran.audited());
        println!(
            "{precision:?}: {:.1} % of {} steps with the CPU's recursions, worst {worst:.2e}, audited {audited:.2e}, off by {off:.1e}, {rows} rows, {crossed} crossed, {through} contacts through a boundary",
            100.0 * part,
            cpu.reports.len()
        );
        assert_eq!(ran.reports.len(), cpu.reports.len());
        assert_eq!(ran.state.bodies.periods, cpu.state.bodies.periods);
        assert_eq!(ran.state.bodies.lineage, cpu.state.bodies.lineage);
        assert!(ran.reports.iter().all(|r| r.unconverged == 0));
        assert!(part >= 0.95 && worst <= 1e-5 && audited <= 1e-5, "{part} {worst:e} {audited:e}");
        assert!(off < if precision == Precision::F32 { f32_bound } else { f64_bound }, "{off:e}");
    }
}

#[test]
fn ellipsoids_driven_through_each_other() {
    follows_the_cpu(&ellipsoids(), 1e-3, 1e-6);
}

#[test]
fn ellipses_in_the_plane() {
    follows_the_cpu(&in_the_plane(Shape::Ellipsoid { radii: [0.45, 0.7, 1.45] }), 1e-3, 1e-6);
}

#[test]
fn one_periodic_axis_mixed_shapes_and_inertia() {
    let shapes = [
        (r#"{"torus": {"major_radius": 1.0, "minor_radius": 0.25}}"#, 0.015),
        (ROD, 0.04),
        (r#"{"sphere": {"radius": 0.5}}"#, 0.01),
    ];
    let rules = shapes.map(|(shape, part)| ["up", "down"].map(|group| rule(group, 5, shape, part)).join(", "));
    let law = r#""dynamics": {"inertial": {"density": 1.0}},"#;
    let mut scene = suspension(false, "[9.7, null, null]", &rules.join(", "), law, 1.5);
    scene.seed = 1;
    // An inexact recursion depends on the last digits.
    scene.contact.recursion = Recursion::Exact;
    follows_the_cpu(&scene, 1e-3, 1e-6);
}

#[test]
fn cells_divide_and_push_their_own_kind_through_the_boundary() {
    let text = r#"{"name": "cells", "seed": 3, "planar": true, "time": {"dt": 0.02, "end": 3.0}, "periodic": {"lengths": [9.0, 14.0, null]},
        "growth": {"rate": 1.0, "division_length": 4.0, "reorientation_degrees": 5.0, "stress_sensitivity": 0.001},
        "generate": [{"founder": {"diameter": 0.5, "length": 2.0}}]}"#;
    let scene = Scene::parse(text, "cells").unwrap();
    let Some(gpu) = device() else { return };
    let cpu = Ran::of(&Compute::Cpu, &scene);
    for precision in precisions(gpu) {
        let ran = Ran::of(&compute(gpu, precision), &scene);
        let bodies = &ran.state.bodies;
        let outside = bodies.position.iter().filter(|x| x.x.abs() > 4.5).count();
        let same = ran.reports.iter().zip(&cpu.reports).filter(|(a, b)| a.recursions == b.recursions).count();
        println!("{precision:?}: {} cells, {outside} outside, {same} of {} alike", bodies.len(), cpu.reports.len());
        assert_eq!(bodies.lineage, cpu.state.bodies.lineage);
        assert!(bodies.len() >= 16 && outside >= 1 && 20 * same >= 19 * cpu.reports.len());
        assert!(ran.worst() <= 1e-5 && ran.audited() <= 1e-5);
    }
}

#[test]
fn two_runs_give_the_same_bits_wherever_the_cell_is_on_the_lattice() {
    let Some(gpu) = device() else { return };
    for scene in [ellipsoids(), planar_rods()] {
        let mut scene = scene;
        scene.time.end = 0.6;
        // On multiples of 2^-24, so that moves by whole pitches round nothing.
        let mut bodies = scene.build().unwrap();
        let round = |x: f64| (x * 2f64.powi(24)).round() / 2f64.powi(24);
        bodies.position.iter_mut().for_each(|x| *x = x.map(round));
        let by = DVec3::new(3.0, -1.0 - 5.0 / 1024.0, if scene.planar { 0.0 } else { 8000.25 });
        let mut moved = bodies.clone();
        moved.position.iter_mut().for_each(|x| *x += by);
        for precision in precisions(gpu) {
            let compute = compute(gpu, precision);
            let [first, second] = [(); 2].map(|()| Ran::from(&compute, &scene, bodies.clone()));
            assert_eq!(state_hash(&first.state), state_hash(&second.state), "{precision:?}");
            assert!(first.worst() <= 1e-5 && first.audited() <= 1e-5);
            let there = Ran::from(&compute, &scene, moved.clone());
            let rows = |ran: &Ran| ran.reports.iter().map(|r| (r.constraints, r.products)).collect::<Vec<_>>();
            assert_eq!(rows(&first), rows(&there), "{precision:?}");
            assert_eq!(first.state.bodies.orientation, there.state.bodies.orientation, "{precision:?}");
            assert_eq!(first.state.bodies.velocity, there.state.bodies.velocity, "{precision:?}");
            assert_eq!(first.state.warm, there.state.warm, "{precision:?}");
        }
    }
}

#[test]
fn the_outcome_does_not_depend_on_where_the_cell_is_or_on_the_images_of_bodies() {
    let Some(gpu) = device() else { return };
    for (planar, mut scene) in [(false, ellipsoids()), (true, planar_rods())] {
        scene.time.end = 0.6;
        let bodies = scene.build().unwrap();
        let length = bodies.periods.length();
        let by = DVec3::new(0.37, -1.91, if planar { 0.0 } else { 5.43 }) * length.max_element();
        let mut moved = bodies.clone();
        for (i, x) in moved.position.iter_mut().enumerate() {
            let cells = DVec3::new([0.0, 1.0, -300.0][i % 3], [2.0, 0.0][i % 2], [0.0, 0.0, 0.0, -1.0][i % 4]);
            *x += by + length * cells;
        }
        for precision in precisions(gpu) {
            let compute = compute(gpu, precision);
            let here = Ran::from(&compute, &scene, bodies.clone());
            let there = Ran::from(&compute, &scene, moved.clone());
            let apart = farthest(&here.state.bodies, &there.state.bodies, by);
            println!("planar {planar}, {precision:?}: {apart:.1e} apart");
            // What the solver's tolerance leaves open is the rounding's to fill.
            assert!(apart < if precision == Precision::F32 { 1e-5 } else { 1e-8 }, "{apart:e}");
        }
    }
}

#[test]
fn a_run_goes_on_from_its_state_after_a_jump_of_a_thousand_cells() {
    let Some(gpu) = device() else { return };
    let scene = planar_rods();
    for precision in precisions(gpu) {
        let compute = compute(gpu, precision);
        let mut straight = Simulation::builder(scene.clone()).on(&compute).build().unwrap();
        for _ in 0..5 {
            straight.step().unwrap();
        }
        let mut state = straight.state().unwrap().clone();
        let length = state.bodies.periods.length();
        state.bodies.position.iter_mut().step_by(4).for_each(|x| *x += 1000.0 * length);
        let mut jumps = Simulation::builder(scene.clone()).on(&compute).resume(state).build().unwrap();
        for _ in 0..5 {
            let (one, other) = (straight.step().unwrap(), jumps.step().unwrap());
            assert_eq!(one.constraints, other.constraints);
        }
        let apart = farthest(&straight.state().unwrap().bodies, &jumps.state().unwrap().bodies, DVec3::ZERO);
        println!("{precision:?}: {apart:.1e} apart");
        assert!(apart < if precision == Precision::F32 { 1e-5 } else { 1e-8 }, "{apart:e}");
    }
}

#[test]
fn a_step_that_leaps_over_images_is_a_fault() {
    let Some(gpu) = device() else { return };
    let text = |force: f64| {
        format!(
            r#"{{"name": "far", "time": {{"dt": 1.0, "end": 3.0}}, "periodic": {{"lengths": [4.0, null, 5.0]}},
            "forces": [{{"uniform": {{"force": [{force}, 0.0, 0.0], "group": "driven"}}}}],
            "bodies": [{{"shape": {{"sphere": {{"radius": 0.25}}}}, "position": [0, 1, 0]}},
                       {{"shape": {{"sphere": {{"radius": 0.25}}}}, "position": [0, 0, 0], "group": "driven"}}]}}"#
        )
    };
    let step = |compute: &Compute, text: &str, radius: Option<f64>| {
        let scene = Scene::parse(text, "far").unwrap();
        let mut bodies = scene.build().unwrap();
        if let Some(radius) = radius {
            bodies.shape[1] = Shape::Sphere { radius };
        }
        Simulation::builder(scene).bodies(bodies).on(compute).build().unwrap().step().map(|report| report.max_overlap)
    };
    let on_cpu = |force: f64, radius| step(&Compute::Cpu, &text(force), radius).unwrap_err();
    let span = |fault: Fault| match fault {
        Fault::PeriodTooShort { step: 1, body: 1, span, period: 4.0 } => span,
        fault => panic!("{fault}"),
    };
    for precision in precisions(gpu) {
        let compute = compute(gpu, precision);
        assert_eq!(step(&compute, &text(0.2), None), Ok(0.0));
        // A body that moves too far, and one of one's own that is longer than the scene's.
        for (force, radius) in [(1000.0, None), (0.2, Some(1.5))] {
            let found = span(step(&compute, &text(force), radius).unwrap_err());
            let expected = span(on_cpu(force, radius));
            assert!((found / expected - 1.0).abs() < 4.0 * precision.epsilon(), "{found} {expected}");
        }
    }
}

#[test]
fn bodies_that_with_the_cutoff_are_just_half_a_period_long_are_not_too_long() {
    let Some(gpu) = device() else { return };
    for period in [4.0, 3.3, 7.7, 10.0 / 3.0] {
        let radius = 0.5 * (0.5 * period - 0.5) * (1.0 - f64::EPSILON);
        let text = format!(
            r#"{{"name": "half", "time": {{"dt": 1.0, "end": 1.0}}, "periodic": {{"lengths": [{period}, null, null]}}, "contact": {{"cutoff": 0.5}},
            "bodies": [{{"shape": {{"sphere": {{"radius": {radius}}}}}, "position": [0, 0, 0]}}]}}"#
        );
        let scene = Scene::parse(&text, "half").unwrap();
        for compute in precisions(gpu).into_iter().map(|precision| compute(gpu, precision)).chain([Compute::Cpu]) {
            assert_eq!(Ran::of(&compute, &scene).worst(), 0.0);
        }
    }
}
