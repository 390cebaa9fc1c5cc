//! Walls: scenes in which no step leaves a body past a wall, audited by the bodies' own points.

use crate::random::{Random, parse};
use glam::DVec3;
use relcp::scene::{Scene, Stepping, Wall};
use relcp::separation::Placed;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use relcp::step::contacts;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const KINDS: [&str; 4] = ["sphere", "spherocylinder", "ellipsoid", "torus"];

/// How far a body reaches past a wall of the scene, from points of its surface and the wall's definition: by none of
/// what steps use.
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
                Shape::Convex(shape) => shape.point(n),
                other => panic!("{other:?}"),
            };
            worst = worst.max(beyond(wall, body.position + body.orientation * local));
        }
    }
    worst
}

/// How far a point is past a wall, by definition.
pub fn beyond(wall: &Wall, p: DVec3) -> f64 {
    match *wall {
        Wall::HalfSpace { normal, offset, .. } => offset - p.dot(DVec3::from(normal).normalize()),
        Wall::Channel { normal, center, width, .. } => {
            (p - DVec3::from(center)).dot(DVec3::from(normal).normalize()).abs() - 0.5 * width
        }
        Wall::Box { minimum, maximum, .. } => (DVec3::from(minimum) - p).max(p - DVec3::from(maximum)).max_element(),
        Wall::Sphere { center, radius, .. } => p.distance(center.into()) - radius,
        Wall::Cylinder { center, axis, radius, length, .. } => {
            let (from, axis) = (p - DVec3::from(center), DVec3::from(axis).normalize());
            let ends = length.map_or(f64::NEG_INFINITY, |length| from.dot(axis).abs() - 0.5 * length);
            (from.cross(axis).length() - radius).max(ends)
        }
        other => panic!("{other:?}"),
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

/// Runs a scene; after every step, or so many of them, no two bodies overlap and none reaches past a wall by more than
/// the tolerance, looked at anew.
fn run_with(scene: Scene, audit_every: u64) -> Ran {
    let (tolerance, walls, planar) = (scene.contact.overlap_tolerance, scene.walls.clone(), scene.planar);
    let mut simulation = Simulation::new(scene).unwrap();
    let mut ran = Ran::default();
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= tolerance && report.unconverged == 0, "{report:?}");
        ran.recursions += report.recursions;
        ran.products += report.products;
        ran.worst = ran.worst.max(report.max_overlap);
        if !report.step.is_multiple_of(audit_every) && !simulation.done() {
            continue;
        }
        let bodies = &simulation.state().unwrap().bodies;
        let pairs = contacts(bodies, 0.0).iter().fold(0.0_f64, |worst, contact| worst.max(-contact.separation));
        let mut outside = 0.0_f64;
        for i in 0..bodies.len() {
            for wall in &walls {
                let mut wall = *wall;
                if let (true, Wall::Box { minimum, maximum, .. }) = (planar, &mut wall) {
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
pub fn colony(planar: bool, dynamics: Value, walls: Value, stepping: Stepping) -> Scene {
    parse(&json!({
        "name": "colony", "seed": 4, "planar": planar, "dynamics": dynamics, "walls": walls,
        "time": {"dt": 0.01, "end": 3.6, "stepping": stepping},
        "growth": {"rate": 1.0, "division_length": 2.0, "reorientation_degrees": 2.0},
        "bodies": [{"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": [0, 0, 0], "orientation": along_x()}]
    }))
}

pub fn overdamped() -> Value {
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
pub fn fall(kinds: &[&str], count: usize, dynamics: Value, walls: Value, steps: u32) -> Scene {
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
