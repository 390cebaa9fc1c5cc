//! Walls: rows against finite differences, and scenes in which no step leaves a body past a wall, audited by the bodies' own points.

use crate::random::{Random, parse};
use glam::DVec3;
use relcp::constraint::{self, FIXED, Mover};
use relcp::dynamics::pressures;
use relcp::dynamics::{Factor, Motion, Pose, Twist, advance};
use relcp::freedom::SPATIAL;
use relcp::lcp::Problem;
use relcp::relcp::{Simulation, contacts};
use relcp::scene::{Dump, DumpWhen, Method, Scene, SolverKind, Stepping, Wall};
use relcp::separation::{Placed, Separation, Surface};
use relcp::shape::Shape;
use relcp::walls::Walls;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const KINDS: [&str; 4] = ["sphere", "spherocylinder", "ellipsoid", "torus"];

// ---- rows ----

const POSES_A_KIND: usize = 40;
/// Step of the fourth-order difference in units of the displacement `dt U`.
const STEP: f64 = 5e-4;

fn moved(placed: &Placed, twist: Twist, dt: f64) -> Placed {
    let pose = advance(Pose { position: placed.position, orientation: placed.orientation }, twist, dt);
    Placed { shape: placed.shape, position: pose.position, orientation: pose.orientation }
}

fn nudged(twist: Twist, axis: usize, by: f64) -> Twist {
    let mut nudged = twist;
    if axis < 3 {
        nudged.linear[axis] += by
    } else {
        nudged.angular[axis - 3] += by
    }
    nudged
}

fn gap(surface: &Surface, placed: &Placed, place: u32) -> Option<Separation> {
    let mut at = None;
    surface.places(placed, |k, found| at = at.or((k == place).then_some(found)));
    at
}

/// The gap at `to` of the place that a body at `from` touches in: of a ring's places beside the farthest that of the same part of its tube.
fn gap_of_place(surface: &Surface, from: &Placed, to: &Placed, place: u32) -> Option<Separation> {
    let (Shape::Torus { minor_radius, .. }, 1..) = (from.shape, place) else { return gap(surface, to, place) };
    let found = gap(surface, from, place)?;
    let arm = from.orientation.inverse() * (found.lever_a - minor_radius * found.normal);
    let part =
        Placed { shape: Shape::Sphere { radius: minor_radius }, position: to.position + to.orientation * arm, ..*to };
    gap(surface, &part, 0)
}

/// Each place's row is the derivative of its gap along `C(U)`, at a start and at a trial, and the wall's block is zero.
#[test]
fn rows_of_walls_equal_finite_differences() {
    let mut random = Random::new(3);
    let motion =
        Motion { free: Twist::default(), factor: Factor { translation: 1.0, rotation: glam::DMat3::IDENTITY } };
    for kind in KINDS {
        for which in 0..3 {
            let (mut checked, mut worst) = (0, 0.0_f64);
            while checked < POSES_A_KIND {
                let dt = 10f64.powf(random.within(-3.0, 0.0));
                let placed =
                    Placed { shape: random.shape(kind), position: random.vector(), orientation: random.orientation() };
                let surface = match which {
                    0 => Surface::Plane { point: random.vector(), normal: random.direction() },
                    1 => Surface::Sphere { centre: random.vector(), radius: random.within(1.0, 4.0) },
                    _ => Surface::Cylinder {
                        centre: random.vector(),
                        axis: random.direction(),
                        radius: random.within(1.0, 4.0),
                    },
                };
                let trial = Twist { linear: random.vector() * 0.05 / dt, angular: random.vector() * 0.3 / dt };
                let at = if checked % 2 == 0 { Twist::default() } else { trial };
                for place in 0..3 {
                    let Some(found) = gap(&surface, &moved(&placed, at, dt), place) else { continue };
                    let mut problem = Problem::<SPATIAL> { bodies: 2, ..Problem::default() };
                    let mover = Mover { motion: &motion, reached_with: at };
                    constraint::append(&mut problem, [0, 1], &found, [mover, FIXED], dt);
                    assert!(problem.jacobian[0][1].iter().all(|x| *x == 0.0));
                    let derivative = problem.jacobian[0][0].map(|x| x * dt.sqrt());
                    let mut expected = [0.0; 6];
                    let mut jumps = false;
                    for (axis, expected) in expected.iter_mut().enumerate() {
                        let here = moved(&placed, at, dt);
                        let phi = |k: f64| {
                            let to = moved(&placed, nudged(at, axis, k * STEP / dt), dt);
                            gap_of_place(&surface, &here, &to, place).unwrap()
                        };
                        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(phi);
                        // Near where another point becomes the farthest.
                        jumps |= a.lever_a.distance(d.lever_a) > 0.1;
                        *expected =
                            (8.0 * (c.separation - b.separation) - (d.separation - a.separation)) / (12.0 * STEP / dt);
                    }
                    if jumps {
                        continue;
                    }
                    let scale = dt * expected.iter().fold(1.0_f64, |m, x| m.max((x / dt).abs()));
                    for (row, expected) in derivative.iter().zip(expected) {
                        worst = worst.max((row - expected).abs() / scale);
                    }
                    let u = [at.linear.to_array(), at.angular.to_array()].concat();
                    let back: f64 = derivative.iter().zip(u).map(|(d, u)| d * u).sum();
                    assert!((problem.q[0] - (found.separation - back)).abs() < 1e-12);
                    checked += 1;
                }
            }
            println!("{kind} {which}: worst {worst:.1e}");
            assert!(worst < 1e-6, "{kind} {which}: {worst:e}");
        }
    }
}

// ---- scenes ----

/// How far a body reaches past a wall of the scene, from points of its surface and the wall's definition: by none of what steps use.
fn past(wall: &Wall, body: &Placed) -> f64 {
    let mut worst = f64::NEG_INFINITY;
    for i in 0..=80 {
        for j in 0..80 {
            let ((s, c), (t, d)) = ((PI * f64::from(i) / 80.0).sin_cos(), (TAU * f64::from(j) / 80.0).sin_cos());
            let n = DVec3::new(s * d, s * t, c);
            let local = match body.shape {
                Shape::Sphere { radius } => radius * n,
                Shape::Spherocylinder { diameter, length } => {
                    0.5 * diameter * n + DVec3::Z * (0.5 * (length - diameter)).copysign(n.z)
                }
                Shape::Ellipsoid { radii } => DVec3::from(radii) * n,
                Shape::Torus { major_radius, minor_radius } => {
                    let (sine, cosine) = (TAU * f64::from(i) / 80.0).sin_cos();
                    DVec3::new(cosine, sine, 0.0) * (major_radius + minor_radius * d) + DVec3::Z * (minor_radius * t)
                }
            };
            worst = worst.max(beyond(wall, body.position + body.orientation * local));
        }
    }
    worst
}

fn beyond(wall: &Wall, p: DVec3) -> f64 {
    match *wall {
        Wall::HalfSpace { normal, offset } => offset - p.dot(DVec3::from(normal).normalize()),
        Wall::Channel { normal, center, width } => {
            (p - DVec3::from(center)).dot(DVec3::from(normal).normalize()).abs() - 0.5 * width
        }
        Wall::Box { minimum, maximum } => (DVec3::from(minimum) - p).max(p - DVec3::from(maximum)).max_element(),
        Wall::Sphere { center, radius } => p.distance(center.into()) - radius,
        Wall::Cylinder { center, axis, radius, length } => {
            let (from, axis) = (p - DVec3::from(center), DVec3::from(axis).normalize());
            let ends = length.map_or(f64::NEG_INFINITY, |length| from.dot(axis).abs() - 0.5 * length);
            (from.cross(axis).length() - radius).max(ends)
        }
    }
}

/// What a run to its end did.
#[derive(Debug, Default)]
struct Ran {
    bodies: usize,
    recursions: u32,
    products: u64,
    worst: f64,
    /// Contacts with walls at the end.
    at_walls: usize,
}

/// Runs a scene; after every step, or so many of them, no two bodies overlap and none reaches past a wall by more than the tolerance, looked at anew.
fn run_with(scene: Scene, audit_every: u64) -> Ran {
    let (tolerance, walls, planar) = (scene.contact.overlap_tolerance, scene.walls.clone(), scene.planar);
    let bodies = scene.build().unwrap();
    let mut simulation = Simulation::new(scene, bodies).unwrap();
    let mut ran = Ran::default();
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= tolerance && report.unconverged == 0, "{report:?}");
        ran.recursions += report.recursions;
        ran.products += report.products;
        ran.worst = ran.worst.max(report.max_overlap);
        if report.step % audit_every != 0 && !simulation.done() {
            continue;
        }
        let bodies = &simulation.state().unwrap().bodies;
        let pairs = contacts(bodies, 0.0).iter().fold(0.0_f64, |worst, (_, s)| worst.max(-s.separation));
        let mut outside = 0.0_f64;
        for i in 0..bodies.len() {
            for wall in &walls {
                let mut wall = *wall;
                if let (true, Wall::Box { minimum, maximum }) = (planar, &mut wall) {
                    (minimum[2], maximum[2]) = (-1e3, 1e3);
                }
                outside = outside.max(past(&wall, &bodies.placed(i)));
            }
        }
        assert!(pairs <= tolerance && outside <= tolerance, "step {}: {pairs:e} {outside:e}", report.step);
        // Points of a surface lie inside of it, so they bound the overlap from below; the step's figure is over both.
        assert!(report.max_overlap >= pairs.max(outside) - 1e-9, "{report:?} {pairs:e} {outside:e}");
    }
    ran.bodies = simulation.bodies();
    ran.at_walls = simulation.wall_contacts(1e-4).unwrap().len();
    ran
}

fn along_x() -> Value {
    let half = 0.5f64.sqrt();
    json!([half, 0.0, half, 0.0])
}

/// A colony from one cell, to 2^5 cells or more.
fn colony(planar: bool, dynamics: Value, walls: Value, stepping: Stepping) -> Scene {
    parse(&json!({
        "name": "colony", "seed": 4, "planar": planar, "dynamics": dynamics, "walls": walls,
        "time": {"dt": 0.01, "end": 3.6, "stepping": stepping},
        "growth": {"rate": 1.0, "division_length": 2.0, "reorientation_degrees": 2.0},
        "bodies": [{"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": [0, 0, 0], "orientation": along_x()}]
    }))
}

fn overdamped() -> Value {
    json!({"overdamped": {"drag": 1.0}})
}

fn inertial() -> Value {
    json!({"inertial": {"density": 1.0}})
}

#[test]
fn a_colony_grows_in_a_channel() {
    let channel = json!([{"channel": {"normal": [0, 2, 0], "center": [0, 0.1, 0], "width": 2.5}}]);
    for dynamics in [overdamped(), inertial()] {
        let ran = run_with(colony(true, dynamics, channel.clone(), Stepping::Euler), 10);
        println!("channel: {ran:?}");
        assert!(ran.bodies >= 32 && ran.at_walls >= 4, "{ran:?}");
    }
    let ran = run_with(colony(true, overdamped(), channel, Stepping::Midpoint), 10);
    println!("channel, midpoint: {ran:?}");
    assert!(ran.bodies >= 32 && ran.at_walls >= 4, "{ran:?}");
}

#[test]
fn a_colony_grows_in_a_disc() {
    // 32 cells of some 0.7 cover 22 of the 38 of the disc.
    let disc = json!([{"cylinder": {"center": [0.2, 0, 0], "axis": [0, 0, 1], "radius": 3.0}}]);
    let ran = run_with(colony(true, overdamped(), disc.clone(), Stepping::Euler), 10);
    println!("disc: {ran:?}");
    assert!(ran.bodies >= 32 && ran.at_walls >= 4, "{ran:?}");
    let ball = json!([{"sphere": {"center": [0.2, 0, 0], "radius": 3.0}}]);
    let same = run_with(colony(true, overdamped(), ball, Stepping::Euler), 50);
    // In the plane a ball about a point of it is a disc, but for rounding.
    assert_eq!(same.bodies, ran.bodies);
}

#[test]
fn a_colony_grows_in_a_box_of_the_plane_and_in_a_tube() {
    let rectangle = json!([{"box": {"minimum": [-2.5, -2, 0], "maximum": [3, 3, 1]}}]);
    let ran = run_with(colony(true, overdamped(), rectangle, Stepping::Euler), 10);
    println!("rectangle: {ran:?}");
    assert!(ran.bodies >= 32 && ran.at_walls >= 4, "{ran:?}");
    let tube = json!([{"cylinder": {"center": [0, 0, 0], "axis": [1, 0.2, 0], "radius": 0.9, "length": 30}}]);
    let ran = run_with(colony(false, overdamped(), tube, Stepping::Euler), 10);
    println!("tube: {ran:?}");
    assert!(ran.bodies >= 32 && ran.at_walls >= 4, "{ran:?}");
}

/// Bodies of the given kinds that fall into a container and come to lie on each other.
fn fall(kinds: &[&str], count: usize, dynamics: Value, walls: Value, steps: u32) -> Scene {
    let mut random = Random::new(9);
    let bodies: Vec<Value> = (0..count)
        .map(|i| {
            let q = random.orientation();
            let shape = match kinds[i % kinds.len()] {
                "sphere" => json!({"sphere": {"radius": 0.5}}),
                "spherocylinder" => json!({"spherocylinder": {"diameter": 0.5, "length": 1.6}}),
                "ellipsoid" => json!({"ellipsoid": {"radii": [0.4, 0.5, 0.8]}}),
                _ => json!({"torus": {"major_radius": 0.7, "minor_radius": 0.1}}),
            };
            let place =
                DVec3::new((i % 2) as f64, (i / 2 % 2) as f64, (i / 4) as f64) * 1.7 - DVec3::new(0.85, 0.85, 0.7);
            json!({"shape": shape, "position": place.to_array(), "orientation": [q.w, q.x, q.y, q.z]})
        })
        .collect();
    let force = match dynamics.get("inertial") {
        Some(_) => json!({"gravity": {"acceleration": [0.3, 0, -2]}}),
        None => json!({"uniform": {"force": [0.3, 0, -2]}}),
    };
    parse(&json!({
        "name": "fall", "dynamics": dynamics, "walls": walls, "forces": [force], "bodies": bodies,
        "time": {"dt": 0.02, "end": 0.02 * f64::from(steps)}
    }))
}

#[test]
fn ellipsoids_are_compacted_in_a_box() {
    let room = json!([{"box": {"minimum": [-1.8, -1.8, -1.8], "maximum": [1.8, 1.8, 8]}}]);
    for dynamics in [overdamped(), inertial()] {
        let ran = run_with(fall(&["ellipsoid"], 12, dynamics, room.clone(), 200), 5);
        println!("box: {ran:?}");
        assert!(ran.at_walls >= 6, "{ran:?}");
    }
}

#[test]
fn every_kind_comes_to_rest_in_every_container() {
    let floor = json!([{"half_space": {"normal": [0, 0, 3], "offset": -2}},
        {"channel": {"normal": [1, 0, 0], "center": [0, 0, 0], "width": 5}}, {"channel": {"normal": [0, 1, 0], "center": [0, 0, 0], "width": 4}}]);
    let ball = json!([{"sphere": {"center": [0, 0, 1], "radius": 3.5}}]);
    let cup = json!([{"cylinder": {"center": [0, 0, 3], "axis": [0, 0, -1], "radius": 2.3, "length": 10}}]);
    for (name, walls) in [("floor", floor), ("ball", ball), ("cup", cup)] {
        for kind in KINDS {
            let ran = run_with(fall(&[kind], 6, overdamped(), walls.clone(), 120), 5);
            println!("{name} {kind}: {ran:?}");
            assert!(ran.at_walls >= 3, "{ran:?}");
        }
        let mixed = ["spherocylinder", "sphere", "ellipsoid"];
        let ran = run_with(fall(&mixed, 8, inertial(), walls.clone(), 150), 5);
        println!("{name} mixed: {ran:?}");
        assert!(ran.at_walls >= 3, "{ran:?}");
    }
}

// ---- what else of a step concerns walls ----

/// A colony in a disc whose cells grow slower under pressure, in midpoint steps.
pub fn a_pressed_colony() -> Scene {
    let disc = json!([{"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 1.5}}]);
    let mut scene = colony(true, overdamped(), disc, Stepping::Midpoint);
    scene.time.end = 2.4;
    scene.growth.as_mut().unwrap().stress_sensitivity = 0.05;
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
    let walls = Walls::of(&scene);
    let mut simulation = Simulation::new(scene, bodies).unwrap();
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
    let room = Wall::Box { minimum: [-1.8; 3], maximum: [1.8, 1.8, 8.0] };
    let of_body = |i: usize| {
        let proxy = bodies.shape[i].proxy(5).unwrap();
        let sphere = |s: &relcp::shape::ProxySphere| {
            beyond(&room, bodies.position[i] + bodies.orientation[i] * s.centre) + s.radius
        };
        proxy.iter().map(sphere).fold(f64::NEG_INFINITY, f64::max)
    };
    (0..bodies.len()).map(of_body).fold(0.0, f64::max)
}

/// A rod that lies on a floor is pressed down, and pushed sideways: the forces of its ends carry its weight, and no more than normal forces act.
#[test]
fn a_floor_carries_the_weight() {
    let scene = parse(&json!({
        "name": "floor", "time": {"dt": 0.05, "end": 5},
        "walls": [{"sphere": {"center": [0, 0, 0], "radius": 40}}, {"half_space": {"normal": [0, 0, 1], "offset": 1}}],
        "forces": [{"uniform": {"force": [0.25, 0, -2]}}],
        "bodies": [{"shape": {"spherocylinder": {"diameter": 1, "length": 4}}, "position": [0, 0, 2], "orientation": [0.8, 0, 0.6, 0]}]
    }));
    let bodies = scene.build().unwrap();
    let mut simulation = Simulation::new(scene, bodies).unwrap();
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
        scene.solver.dump = Some(Dump { when: DumpWhen::All, products: None, most: Some(1000) });
        let bodies = scene.build().unwrap();
        let mut simulation = Simulation::new(scene, bodies).unwrap();
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
    for kind in [SolverKind::PairBlockCg, SolverKind::ProjectedGaussSeidel, SolverKind::Bbpgd, SolverKind::Dense] {
        let found = run(kind);
        let off = found.iter().zip(&reference).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
        println!("{kind:?}: {off:.1e}");
        assert!(off < 1e-6, "{kind:?} {off:e}");
    }
}
