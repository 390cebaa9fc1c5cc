//! Forces on walls against balances of whole scenes: weights of a heap, the stress of a squeezed suspension, the torque
//! on a turning drum, and the virial of a gas.

use super::super::walls::OnWalls;
use super::*;
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::step::State;
use crate::walls::{Walls, standing};
use serde_json::{Value, json};

fn started(of: &Value) -> Simulation {
    Simulation::new(Scene::parse(&of.to_string(), "test").unwrap()).unwrap()
}

fn snapshot(simulation: &Simulation) -> Snapshot {
    let State { step, bodies, warm, .. } = simulation.state().unwrap().clone();
    Snapshot { step, time: simulation.time(), bodies, warm: Some(warm), removed: Vec::new(), fields: Vec::new() }
}

/// The sums over all contacts of pairs and walls of force times lever, and over all walls of force times point.
fn virials(simulation: &Simulation, frame: &Frame) -> [f64; 2] {
    let (state, settings) = (snapshot(simulation), Settings::default());
    let view = View::new(&state, frame, &settings);
    let walls = Walls::new(&standing(&frame.walls, &state.bodies.walls), frame.planar).at(state.time);
    let at_walls = walls.pushes(&state.bodies, state.warm.as_deref().unwrap()).map(|push| push.force.dot(push.point));
    [view.virials().unwrap().iter().sum(), at_walls.sum()]
}

/// `xi L` times the mean velocity over a step that moves a body by `way`.
fn dragged(shape: &Shape, way: DVec3, dt: f64) -> DVec3 {
    shape.major_axis() / dt * way
}

/// A heap of bodies of three kinds, in a trough, that still settles: its walls bear all weights but what drag bears.
#[test]
fn walls_of_a_trough_bear_the_weight_of_a_heap() {
    let (dt, weight) = (0.01, 0.7);
    let of = json!({"name": "heap", "time": {"dt": dt, "end": 6}, "dynamics": {"overdamped": {"drag": 1}},
        "solver": {"tolerance": 1e-12}, "periodic": {"lengths": [null, 6, null]},
        "walls": [{"half_space": {"normal": [1, 0, 1], "offset": 0}}, {"half_space": {"normal": [-1, 0, 1], "offset": 0}},
            {"half_space": {"normal": [0, 0, -1], "offset": -9}}],
        "forces": [{"uniform": {"force": [0, 0, -weight]}}],
        "generate": [{"isotropic": {"count": 12, "shape": {"sphere": {"radius": 0.5}},
            "mixture": [{"count": 12, "shape": {"ellipsoid": {"radii": [0.3, 0.4, 0.8]}}},
                {"count": 12, "shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}}]}}]});
    let mut simulation = started(&of);
    let frame = Frame::of_scene(&Scene::parse(&of.to_string(), "test").unwrap(), "a test".into());
    let mut worst = 0.0_f64;
    while !simulation.done() {
        let before = simulation.state().unwrap().bodies.clone();
        simulation.step().unwrap();
        let state = snapshot(&simulation);
        let found = OnWalls.of(&View::new(&state, &frame, &Settings::default())).unwrap();
        let drag = |i: usize| dragged(&before.shape[i], state.bodies.position[i] - before.position[i], dt).z;
        let all: f64 = (0..before.len()).map(drag).sum();
        let borne = value(&found, "walls", "wall_force_z").unwrap();
        let expected = -36.0 * weight - all;
        worst = worst.max((borne - expected).abs() / (36.0 * weight));
    }
    println!("walls bear the weight within {worst:.1e} of it");
    assert!(worst < 1e-6, "{worst:e}");
}

/// Rods between walls that close in: the force on walls times their places is the virial of all contacts, less what
/// drag bears.
#[test]
fn the_pressure_on_walls_is_the_stress_of_a_squeezed_suspension() {
    let dt = 0.01;
    let side = |normal: [i32; 2]| {
        let velocity = normal.map(|n| 0.3 * f64::from(n));
        json!({"half_space": {"normal": [normal[0], normal[1], 0], "offset": -6, "motion": {"velocity": [velocity[0], velocity[1], 0]}}})
    };
    let of = json!({"name": "squeezed", "planar": true, "time": {"dt": dt, "end": 7}, "dynamics": {"overdamped": {"drag": 1}},
        "solver": {"tolerance": 1e-11}, "contact": {"overlap_tolerance": 1e-7},
        "walls": [side([1, 0]), side([-1, 0]), side([0, 1]), side([0, -1])],
        "generate": [{"isotropic": {"count": 40, "shape": {"spherocylinder": {"diameter": 0.6, "length": 1.5}}}}]});
    let mut simulation = started(&of);
    let frame = Frame::of_scene(&Scene::parse(&of.to_string(), "test").unwrap(), "a test".into());
    let (mut worst, mut share) = (0.0_f64, 0.0);
    while !simulation.done() {
        let before = simulation.state().unwrap().bodies.clone();
        simulation.step().unwrap();
        let state = simulation.state().unwrap();
        let [of_all, at_walls] = virials(&simulation, &frame);
        let drag = |i: usize| {
            let (from, to) = (before.position[i], state.bodies.position[i]);
            dragged(&before.shape[i], to - from, dt).dot(to)
        };
        let dragged: f64 = (0..before.len()).map(drag).sum();
        worst = worst.max((at_walls - (of_all - dragged)).abs() / at_walls.max(1.0));
        share = of_all / at_walls;
    }
    println!("within {worst:.1e}; the contacts' virial is {share:.3} of the walls' at the end");
    assert!(worst < 1e-3, "{worst:e}");
}

/// A rod in a drum that slides under it, at rest where friction bears it: at `mu R (1 + mu tan a) = ((R - r) cos^2 b
/// (1 + mu^2) - mu^2 R) tan a` for the angle `a` of its middle, with the half angle `b` between its ends. The torque on
/// the drum is that of its weight.
#[test]
fn the_torque_on_a_turning_drum_is_that_of_the_weight_it_holds() {
    let (mu, radius, r, half, weight) = (0.4, 3.0, 0.25, 1.0, 20.0);
    let out = radius - r;
    let sine: f64 = half / out;
    let middle = out * (1.0 - sine * sine).sqrt();
    let of = json!({"name": "drum", "planar": true, "time": {"dt": 0.002, "end": 8}, "dynamics": {"overdamped": {"drag": 1}},
        "contact": {"friction": mu, "overlap_tolerance": 1e-8}, "solver": {"tolerance": 1e-12},
        "walls": [{"cylinder": {"center": [1, 2, 0], "axis": [0, 0, 1], "radius": radius,
            "motion": {"velocity": [0, 0, 0], "angular_velocity": [0, 0, 0.5]}}}],
        "forces": [{"uniform": {"force": [0, -weight, 0]}}],
        "bodies": [{"shape": {"spherocylinder": {"diameter": 2.0 * r, "length": 2.0 * (half + r)}}, "position": [1, 2.0 - middle, 0],
            "axis": [1, 0, 0]}]});
    let mut simulation = started(&of);
    let frame = Frame::of_scene(&Scene::parse(&of.to_string(), "test").unwrap(), "a test".into());
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let state = snapshot(&simulation);
    let at = state.bodies.position[0] - DVec3::new(1.0, 2.0, 0.0);
    let tangent = mu * radius / (out * (1.0 - sine * sine) * (1.0 + mu * mu) - mu * mu * radius);
    let found = OnWalls.of(&View::new(&state, &frame, &Settings::default())).unwrap();
    let torque = found.rows[0][OnWalls.profile().unwrap().columns.iter().position(|c| c.name == "torque_z").unwrap()];
    println!("at {at}, tan {} for {tangent}, torque {torque:?} for {}", -at.x / at.y, -weight * at.x);
    assert!((-at.x / at.y / tangent - 1.0).abs() < 1e-6, "{at} {tangent}");
    assert!(at.x > 0.5);
    assert_near(torque, -weight * at.x, 1e-5 * weight);
}

/// Elastic balls in a box, as a gas: on average walls bear what twice the kinetic energy and the contacts' virial are.
#[test]
fn the_pressure_of_a_gas_is_its_virial() {
    let (dt, end, density) = (2e-3, 60.0, 1.0);
    let of = json!({"name": "gas", "planar": true, "time": {"dt": dt, "end": end}, "dynamics": {"inertial": {"density": density}},
        "contact": {"restitution": 1}, "walls": [{"box": {"minimum": [-3, -3, -1], "maximum": [3, 3, 1]}}],
        "generate": [{"isotropic": {"count": 16, "shape": {"sphere": {"radius": 0.4}}}}]});
    let mut scene = Scene::parse(&of.to_string(), "test").unwrap();
    scene = Scene::parse(&Simulation::new(scene).unwrap().final_scene().unwrap().to_json(), "test").unwrap();
    for (i, body) in scene.bodies.iter_mut().enumerate() {
        let angle = 2.4 * i as f64;
        body.velocity = Some([angle.cos(), angle.sin(), 0.0]);
    }
    let frame = Frame::of_scene(&scene, "a test".into());
    let mut simulation = Simulation::new(scene).unwrap();
    let mass = BALL_MASS * density;
    let (mut twice_energy, mut pairs, mut walls, mut steps) = (0.0, 0.0, 0.0, 0.0);
    while !simulation.done() {
        simulation.step().unwrap();
        let [of_all, at_walls] = virials(&simulation, &frame);
        let state = simulation.state().unwrap();
        twice_energy += mass * state.bodies.velocity.iter().map(|v| v.length_squared()).sum::<f64>();
        // Levers of walls are radii, which belong to the walls' places.
        let of_walls = state.warm.iter().filter(|warm| crate::walls::surface_of(warm.pair[1]).is_some());
        let levers: f64 = 0.4 * of_walls.map(|warm| warm.gamma).sum::<f64>();
        (pairs, walls, steps) = (pairs + of_all - levers, walls + at_walls - levers, steps + 1.0);
    }
    let [energy, pairs, walls] = [twice_energy, pairs, walls].map(|sum| sum / steps);
    println!(
        "walls {walls:.4}, twice the kinetic energy {energy:.4}, pairs {pairs:.4}, {:.4}",
        walls / (energy + pairs)
    );
    assert!(pairs > 0.1 * energy && (energy / (16.0 * mass) - 1.0).abs() < 0.01, "{energy} {pairs}");
    assert!((walls / (energy + pairs) - 1.0).abs() < 0.02, "{walls} {energy} {pairs}");
}

/// A ball of radius 0.4, in space.
const BALL_MASS: f64 = 4.0 / 3.0 * PI * 0.064;
