//! Runs between walls on the device against the CPU's: the same recursions, overlaps with walls audited in f64,
//! pressures, what is remembered.

use crate::device::{device, precisions};
use glam::DVec3;
use relcp::dynamics::pressures;
use relcp::gpu::{Gpu, Precision};
use relcp::record::state_hash;
use relcp::scene::{self, Force, Periodic, Recursion, Scene};
use relcp::simulation::{Compute, Simulation};
use relcp::step::{StepReport, contacts};
use relcp::walls::{Walls, surface_of};
use serde_json::{Value, json};
use std::sync::Arc;

struct Ran {
    simulation: Simulation,
    reports: Vec<StepReport>,
}

impl Ran {
    fn on(compute: &Compute, scene: &Scene) -> Ran {
        let mut simulation = Simulation::builder(scene.clone()).on(compute).build().unwrap();
        let mut reports = Vec::new();
        while !simulation.done() {
            reports.push(simulation.step().unwrap());
        }
        Ran { simulation, reports }
    }

    /// The largest overlap of the final state, of bodies and with walls, in f64 on the CPU.
    fn audited(&self, walls: &Walls) -> [f64; 2] {
        let bodies = &self.simulation.state().unwrap().bodies;
        let pairs = contacts(bodies, 0.0).iter().fold(0.0_f64, |worst, contact| worst.max(-contact.separation));
        [pairs, walls.max_overlap(bodies)]
    }

    fn positions(&self) -> Vec<DVec3> {
        self.simulation.state().unwrap().bodies.position.clone()
    }
}

fn on_device(gpu: &Arc<Gpu>, precision: Precision) -> Compute {
    Compute::Gpu { gpu: gpu.clone(), precision }
}

/// Runs a scene on the CPU and on the device in every precision, and holds the device to its tolerances and to the
/// CPU's recursions; `off` is how far a position may be from the CPU's, in 32 and in 64 bits.
fn both(scene: &Scene, off: [f64; 2], check: impl Fn(&Ran, &Ran)) {
    let Some(gpu) = device() else { return };
    // An inexact recursion depends on the last digits.
    let mut exact = scene.clone();
    exact.contact.recursion = Recursion::Exact;
    let scene = &exact;
    let (walls, cpu) = (scene.walls(), Ran::on(&Compute::Cpu, scene));
    assert!(cpu.simulation.wall_contacts(1e-4).unwrap().len() >= 3, "{}: nothing at the walls", scene.name);
    for precision in precisions(gpu) {
        let ran = Ran::on(&on_device(gpu, precision), scene);
        let same = ran.reports.iter().zip(&cpu.reports).filter(|(a, b)| a.recursions == b.recursions).count();
        let part = same as f64 / cpu.reports.len() as f64;
        let worst = ran.reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max);
        let [of_pairs, of_walls] = ran.audited(&walls);
        let furthest = ran.positions().iter().zip(cpu.positions()).map(|(x, y)| x.distance(y)).fold(0.0, f64::max);
        let at_walls = ran.reports.iter().filter(|r| r.worst_wall.is_some()).count();
        let sum = |of: fn(&StepReport) -> u64, ran: &Ran| ran.reports.iter().map(of).sum::<u64>();
        println!(
            "{} {precision:?}: {} steps, {:.1} % with the CPU's recursions ({}), worst {worst:.2e}, audited {of_pairs:.2e} and at walls {of_walls:.2e}, \
            {at_walls} steps worst at a wall, positions off by {furthest:.1e}, products {} (CPU {})",
            scene.name,
            ran.reports.len(),
            100.0 * part,
            sum(|r| u64::from(r.recursions), &ran),
            sum(|r| r.products, &ran),
            sum(|r| r.products, &cpu),
        );
        assert_eq!(ran.reports.len(), cpu.reports.len());
        assert!(part >= 0.95, "{} {precision:?}: {part}", scene.name);
        assert!(worst <= 1e-5 && of_pairs <= 1e-5 && of_walls <= 1e-5, "{worst:e} {of_pairs:e} {of_walls:e}");
        assert!(ran.reports.iter().all(|r| r.unconverged == 0));
        // What the device measured last is what the audit finds.
        let last = ran.reports.last().unwrap().max_overlap;
        assert!((last - of_pairs.max(of_walls)).abs() <= 2e-6, "{last:e} {of_pairs:e} {of_walls:e}");
        assert!(
            furthest <= off[usize::from(precision == Precision::F64)],
            "{} {precision:?}: {furthest:e}",
            scene.name
        );
        check(&ran, &cpu);
    }
}

fn parse(scene: &Value) -> Scene {
    Scene::parse(&scene.to_string(), "test").unwrap()
}

fn colony(name: &str, end: f64, walls: Value, stress_sensitivity: f64) -> Scene {
    parse(&json!({
        "name": name, "seed": 4, "planar": true, "walls": walls, "time": {"dt": 0.01, "end": end},
        "growth": {"rate": 1.0, "division_length": 2.0, "reorientation_degrees": 2.0, "stress_sensitivity": stress_sensitivity},
        "bodies": [{"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": [0, 0, 0], "orientation": [0.5f64.sqrt(), 0, 0.5f64.sqrt(), 0]}]
    }))
}

/// Bodies that fall into a container, tilted so that no two contacts are alike.
fn fall(name: &str, shapes: &[Value], (count, steps): (usize, u32), dynamics: &str, walls: Value) -> Scene {
    let body = |i: usize| {
        let place = DVec3::new((i % 2) as f64, (i / 2 % 2) as f64, (i / 4) as f64) * 1.7 - DVec3::new(0.85, 0.85, 0.7);
        let lean = (i as f64 * 0.7).sin();
        json!({"shape": shapes[i % shapes.len()], "position": place.to_array(), "orientation": [1.0, lean, 0.4 - lean, 0.3 * lean]})
    };
    let (dynamics, force) = match dynamics {
        "inertial" => (json!({"inertial": {"density": 1.0}}), json!({"gravity": {"acceleration": [0.3, 0, -2]}})),
        _ => (json!({"overdamped": {"drag": 1.0}}), json!({"uniform": {"force": [0.3, 0, -2]}})),
    };
    parse(&json!({
        "name": name, "dynamics": dynamics, "walls": walls, "forces": [force], "bodies": (0..count).map(body).collect::<Vec<_>>(),
        "time": {"dt": 0.02, "end": 0.02 * f64::from(steps)}
    }))
}

fn rod() -> Value {
    json!({"spherocylinder": {"diameter": 0.5, "length": 1.6}})
}

fn ball() -> Value {
    json!({"sphere": {"radius": 0.5}})
}

fn ellipsoid() -> Value {
    json!({"ellipsoid": {"radii": [0.4, 0.5, 0.8]}})
}

fn ring() -> Value {
    json!({"torus": {"major_radius": 0.7, "minor_radius": 0.1}})
}

fn room() -> Value {
    json!([{"box": {"minimum": [-1.8, -1.8, -1.8], "maximum": [1.8, 1.8, 8]}}])
}

fn disc(radius: f64) -> Value {
    json!([{"cylinder": {"center": [0.1, 0, 0], "axis": [0, 0, 1], "radius": radius}}])
}

#[test]
fn a_colony_in_a_channel() {
    let walls = json!([{"channel": {"normal": [0.1, 2, 0], "center": [0, 0.1, 0], "width": 1.4}}]);
    both(&colony("channel", 2.6, walls, 0.0), [1e-3, 2e-6], |ran, cpu| {
        assert!(ran.simulation.bodies() == cpu.simulation.bodies() && ran.simulation.bodies() >= 8);
        assert!(ran.positions().iter().all(|x| x.z == 0.0));
    });
}

/// Cells that feel how they press on the wall and on each other.
#[test]
fn a_pressed_colony_in_a_disc() {
    both(&colony("disc", 2.1, disc(1.5), 0.05), [1e-3, 2e-6], |ran, cpu| {
        let pressure = |ran: &Ran| {
            let state = ran.simulation.state().unwrap();
            let at_walls = state.warm.iter().filter(|w| surface_of(w.pair[1]).is_some() && w.gamma > 0.0);
            (at_walls.map(|w| w.gamma).sum::<f64>(), pressures(&state.bodies, &state.warm, true))
        };
        let ((force, ours), (expected, theirs)) = (pressure(ran), pressure(cpu));
        assert!(expected > 0.1 && (force / expected - 1.0).abs() < 2e-2, "{force} {expected}");
        let most = theirs.iter().copied().fold(0.0, f64::max);
        let off = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / most;
        println!("  force on the wall {force:.6} (CPU {expected:.6}), pressures off by {off:.1e} of {most:.2}");
        assert!(ours.len() == theirs.len() && off < 5e-2, "{off:e}");
    });
}

#[test]
fn ellipsoids_fall_into_a_box() {
    for dynamics in ["overdamped", "inertial"] {
        both(&fall(&format!("box, {dynamics}"), &[ellipsoid()], (8, 80), dynamics, room()), [1e-3, 2e-6], |_, _| ());
    }
}

#[test]
fn mixed_bodies_fall_into_round_containers() {
    let sphere = json!([{"sphere": {"center": [0, 0, 1], "radius": 3.5}}]);
    let cup = json!([{"cylinder": {"center": [0, 0, 3], "axis": [0.1, 0, -1], "radius": 2.5, "length": 10}}]);
    both(&fall("sphere", &[rod(), ball(), ellipsoid()], (8, 80), "inertial", sphere.clone()), [1e-3, 2e-6], |_, _| ());
    both(&fall("cup", &[rod(), ball(), ring()], (6, 80), "overdamped", cup), [1e-3, 2e-6], |_, _| ());
    both(&fall("rings", &[ring()], (6, 80), "overdamped", sphere), [1e-3, 2e-6], |_, _| ());
}

/// Bodies that slide along a floor and leave their cell on one side, to meet each other through it.
#[test]
fn bodies_slide_on_a_floor_through_the_boundaries_of_a_cell() {
    let mut scene = fall(
        "floor",
        &[rod(), ball()],
        (8, 100),
        "overdamped",
        json!([{"half_space": {"normal": [0, 0, 1], "offset": -1.6}}]),
    );
    let Force::Uniform { force, .. } = &mut scene.forces[0] else { panic!("{:?}", scene.forces) };
    force[0] = 3.0;
    scene.periodic = Some(Periodic::new([Some(4.2), Some(4.4), None]));
    scene.validate().unwrap();
    both(&scene, [1e-3, 2e-6], |ran, _| {
        let bodies = &ran.simulation.state().unwrap().bodies;
        assert!(bodies.position.iter().any(|x| x.x > 2.1), "{:?}", bodies.position);
        let through =
            |[a, b]: [usize; 2]| (bodies.position[a] - bodies.position[b]).truncate().abs().max_element() > 2.2;
        assert!(contacts(bodies, 1e-4).iter().any(|contact| through(contact.bodies)));
    });
}

/// Rods on the bottom of a sphere of 5,000 diameters, and its centre as far away: the overlap is that of the audit, not
/// of rounding.
#[test]
fn a_large_wall_is_exact() {
    let walls = json!([{"sphere": {"center": [1200, -1600, 1500], "radius": 2500}}, {"half_space": {"normal": [0.3, 0.4, 0.8], "offset": -1146.5}}]);
    let mut scene = fall("large sphere", &[rod(), ellipsoid()], (6, 80), "overdamped", json!([]));
    let walls: Vec<scene::Wall> = serde_json::from_value(walls).unwrap();
    scene.walls = walls;
    for body in &mut scene.bodies {
        // From the middle towards the bottom, two diameters above it.
        let down = DVec3::new(1200.0, -1600.0, 1500.0 - 2497.0);
        body.position = (DVec3::from(body.position) + down).to_array();
    }
    both(&scene, [1e-3, 2e-6], |_, _| ());
}

#[test]
fn two_runs_have_the_same_bits() {
    let Some(gpu) = device() else { return };
    for scene in [colony("disc", 1.3, disc(1.2), 0.0), fall("box", &[ellipsoid()], (6, 40), "inertial", room())] {
        for precision in precisions(gpu) {
            let run = || {
                let ran = Ran::on(&on_device(gpu, precision), &scene);
                let at_walls = ran.simulation.wall_contacts(1e-4).unwrap().len();
                (state_hash(ran.simulation.state().unwrap()), at_walls)
            };
            let (first, second) = (run(), run());
            assert!(first.1 > 0);
            assert_eq!(first, second, "{} {precision:?}", scene.name);
        }
    }
}

/// A state goes on on the other backend, with what is remembered of places at walls.
#[test]
fn a_run_goes_on_from_its_state() {
    let Some(gpu) = device() else { return };
    let scene = fall("box", &[rod()], (6, 60), "overdamped", room());
    for precision in precisions(gpu) {
        let [device, cpu] = [on_device(gpu, precision), Compute::Cpu];
        for (from, to) in [(&device, &device), (&device, &cpu), (&cpu, &device)] {
            let whole = Ran::on(from, &scene);
            let mut half = Simulation::builder(scene.clone()).on(from).build().unwrap();
            (0..40).for_each(|_| assert!(half.step().unwrap().max_overlap <= 1e-5));
            let state = half.state().unwrap().clone();
            let at_walls: Vec<_> =
                state.warm.iter().filter(|w| surface_of(w.pair[1]).is_some() && w.gamma > 0.0).collect();
            assert!(
                at_walls.len() >= 3
                    && at_walls.iter().all(|w| w.normal.is_normalized() || w.normal.length() > 0.999_999)
            );
            let mut resumed = Simulation::builder(scene.clone()).on(to).resume(state).build().unwrap();
            (0..20).for_each(|_| assert!(resumed.step().unwrap().max_overlap <= 1e-5));
            let ended = &resumed.state().unwrap().bodies.position;
            let off = ended.iter().zip(whole.positions()).map(|(x, y)| x.distance(y)).fold(0.0, f64::max);
            println!("{precision:?}: off by {off:.1e}");
            // As far as solves within the tolerance may differ.
            assert!(off < 1e-4, "{off:e}");
        }
    }
}
