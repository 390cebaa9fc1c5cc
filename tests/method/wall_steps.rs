//! What else of a step concerns walls: sub-spheres, forces and pressures, every solver, and what is remembered.

use crate::random::parse;
use crate::walls::{beyond, colony, fall, overdamped};
use glam::DVec3;
use relcp::dynamics::pressures;
use relcp::measure::{Frame, Settings, View};
use relcp::record::Snapshot;
use relcp::scene::{Dump, DumpWhen, Method, Scene, SolverKind, Stepping, Wall};
use relcp::simulation::Simulation;
use relcp::walls::surface_of;
use serde_json::json;

/// A colony in a disc whose cells grow slower under pressure, in midpoint steps.
pub fn a_pressed_colony() -> Scene {
    let disc = json!([{"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 1.5}}]);
    let mut scene = colony(true, overdamped(), disc, Stepping::Midpoint);
    scene.time.end = 2.3;
    scene.growth[0].stress_sensitivity = 0.05;
    scene
}

/// Rows of sub-spheres with walls.
pub fn sub_spheres_in_a_box() -> Scene {
    let room = json!([{"box": {"minimum": [-1.8, -1.8, -1.8], "maximum": [1.8, 1.8, 8]}}]);
    let mut scene = fall(&["ellipsoid", "spherocylinder"], 8, overdamped(), room, 60);
    scene.contact.method = Method::Multisphere { count: 5 };
    scene
}

#[test]
fn sub_spheres_stay_inside_too() {
    let scene = sub_spheres_in_a_box();
    let bodies = scene.build().unwrap();
    let walls = scene.walls();
    let mut simulation = Simulation::builder(scene).bodies(bodies).build().unwrap();
    let (mut proxy, mut smooth, mut walls_worst) = (0.0_f64, 0.0_f64, 0);
    while !simulation.done() {
        let report = simulation.step().unwrap();
        let bodies = &simulation.state().unwrap().bodies;
        let outside = walls.max_overlap(bodies);
        assert!(report.max_overlap >= outside, "{report:?} {outside}");
        proxy = proxy.max(report.proxy_overlap.unwrap());
        smooth = smooth.max(outside);
        walls_worst += usize::from(report.worst_wall.is_some());
        let past_proxy = past_of_sub_spheres(bodies);
        assert!((past_proxy <= report.proxy_overlap.unwrap() + 1e-12) && past_proxy < 0.02, "{past_proxy} {report:?}");
    }
    println!("sub-spheres past walls {proxy:.1e}, surfaces {smooth:.1e}, {walls_worst} steps");
    // Ellipsoids reach past the walls between their sub-spheres.
    assert!(smooth > 1e-4 && walls_worst > 0);
}

/// How far a sub-sphere reaches out of the box of [`sub_spheres_in_a_box`].
fn past_of_sub_spheres(bodies: &relcp::bodies::Bodies) -> f64 {
    let room = Wall::Box { minimum: [-1.8; 3], maximum: [1.8, 1.8, 8.0], motion: None, friction: None };
    let of_body = |i: usize| {
        let proxy = bodies.shape[i].proxy(5).unwrap();
        let sphere = |s: &relcp::shape::ProxySphere| {
            beyond(&room, bodies.position[i] + bodies.orientation[i] * s.centre) + s.radius
        };
        proxy.iter().map(sphere).fold(f64::NEG_INFINITY, f64::max)
    };
    (0..bodies.len()).map(of_body).fold(0.0, f64::max)
}

/// A rod that lies on a floor is pressed down, and pushed sideways: the forces of its ends carry its weight, and no
/// more than normal forces act.
#[test]
fn a_floor_carries_the_weight() {
    let scene = parse(&json!({
        "name": "floor", "time": {"dt": 0.05, "end": 5},
        "walls": [{"sphere": {"center": [0, 0, 0], "radius": 40}}, {"half_space": {"normal": [0, 0, 1], "offset": 1}}],
        "forces": [{"uniform": {"force": [0.25, 0, -2]}}],
        "bodies": [{"shape": {"spherocylinder": {"diameter": 1, "length": 4}}, "position": [0, 0, 2], "orientation": [0.8, 0, 0.6, 0]}]
    }));
    let mut simulation = Simulation::new(scene).unwrap();
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
    }
    let state = simulation.state().unwrap();
    let force: f64 = state.warm.iter().map(|w| w.gamma).sum();
    assert!((force - 2.0).abs() < 1e-4, "{:?}", state.warm);
    assert!(state.warm.iter().filter(|w| w.gamma > 0.1).count() == 2, "{:?}", state.warm);
    assert!(state.warm.iter().all(|w| w.normal == DVec3::NEG_Z && w.pair[0] == 0));
    // Without friction it slides at F / (xi L) all the while.
    assert!((state.bodies.position[0].x - 0.25 / 4.0 * 5.0).abs() < 1e-3, "{}", state.bodies.position[0]);
    assert!((state.bodies.position[0].z - 1.5).abs() < 1e-5);
    // Its virial is the force times half its thickness.
    let pressed = pressures(&state.bodies, &state.warm, false)[0];
    assert!((pressed - 2.0 * 0.5 / (3.0 * state.bodies.shape[0].volume())).abs() < 1e-4, "{pressed}");
}

/// Every solver finds the velocities of a problem with walls, and what is stored of one is that problem.
#[test]
fn every_solver_solves_problems_with_walls() {
    let run = |kind: SolverKind| {
        let mut scene = a_pressed_colony();
        scene.time.end = 1.6;
        scene.time.stepping = Stepping::Euler;
        scene.contact.overlap_tolerance = 1e-6;
        scene.solver.kind = kind;
        scene.solver.tolerance = Some(1e-10);
        let mut dump = Dump::new(DumpWhen::All);
        dump.most = Some(1000);
        scene.solver.dump = Some(dump);
        let mut simulation = Simulation::new(scene).unwrap();
        let mut worst = 0.0_f64;
        while !simulation.done() {
            assert_eq!(simulation.step().unwrap().unconverged, 0, "{kind:?}");
            for kept in simulation.take_lcps() {
                worst = worst.max(kept.lcp.residual(&kept.lcp.gamma));
            }
        }
        assert!(worst <= 1.1e-10, "{kind:?} {worst:e}");
        simulation.state().unwrap().bodies.position.clone()
    };
    let reference = run(SolverKind::InteriorPoint);
    for kind in [
        SolverKind::PairBlockCg,
        SolverKind::ClusterCg,
        SolverKind::ProjectedGaussSeidel,
        SolverKind::Bbpgd,
        SolverKind::Dense,
    ] {
        let found = run(kind);
        let off = found.iter().zip(&reference).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
        println!("{kind:?}: {off:.1e}");
        assert!(off < 1e-6, "{kind:?} {off:e}");
    }
}

/// The pressure that growth feels is the one that is measured, and what is remembered of walls is of no harm to a scene
/// that has none.
#[test]
fn what_is_remembered_of_walls_is_a_pressure() {
    let scene = a_pressed_colony();
    let frame = Frame::of_scene(&scene, "colony".into());
    let bodies = scene.build().unwrap();
    let mut simulation = Simulation::builder(scene.clone()).bodies(bodies).build().unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let state = simulation.state().unwrap().clone();
    let at_walls: f64 = state.warm.iter().filter(|w| surface_of(w.pair[1]).is_some()).map(|w| w.gamma).sum();
    assert!(at_walls > 0.1, "{at_walls}");
    let felt = pressures(&state.bodies, &state.warm, true);
    let without: Vec<_> = state.warm.iter().filter(|w| surface_of(w.pair[1]).is_none()).copied().collect();
    assert_ne!(felt, pressures(&state.bodies, &without, true));
    let snapshot = Snapshot {
        step: state.step,
        time: 1.0,
        bodies: state.bodies.clone(),
        warm: Some(state.warm.clone()),
        removed: Vec::new(),
        fields: Vec::new(),
    };
    let settings = Settings::default();
    let view = View::new(&snapshot, &frame, &settings);
    for ((felt, virial), area) in felt.iter().zip(view.virials().unwrap()).zip(&view.volumes) {
        assert!((felt - virial / (2.0 * area)).abs() <= 1e-12 * felt.abs().max(1.0));
    }
    let mut open = scene;
    open.walls.clear();
    let mut free = Simulation::builder(open).resume(state).build().unwrap();
    assert!(free.step().unwrap().max_overlap <= 1e-5);
    assert!(free.state().unwrap().warm.iter().all(|w| surface_of(w.pair[1]).is_none()));
}
