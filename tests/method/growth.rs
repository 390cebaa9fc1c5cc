//! Growth and division, and that a run is the same to the bit on any number of threads and after a resume.

use crate::laws::{body, rod, start};
use crate::random::parse;
use glam::{DQuat, DVec3};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::internals::dynamics::grow;
use relcp::scene::{Dynamics, Growth, Scene, Stepping, Wall};
use relcp::separation::Placed;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use relcp::step::{State, contacts};
use serde_json::json;
use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, LN_2};

const GROWTH: Growth = turning(Growth::new(1.0, 4.0), 0.01);

/// The same with daughters that turn by up to these degrees.
const fn turning(mut growth: Growth, degrees: f64) -> Growth {
    growth.reorientation_degrees = degrees;
    growth
}

fn cells(poses: &[(u64, f64, DVec3, DQuat)]) -> Bodies {
    let mut bodies = Bodies::default();
    for &(id, length, position, orientation) in poses {
        let shape = Shape::Spherocylinder { diameter: 0.5, length };
        let i = bodies.push(Placed { shape, position, orientation }, NO_GROUP);
        bodies.lineage[i].id = id;
    }
    bodies
}

fn length(shape: &Shape) -> f64 {
    shape.growing_length().unwrap()
}

/// The outer tips and the inner ones of cells 0 and 1 along the axis of the first.
fn tips(bodies: &Bodies, i: usize) -> [DVec3; 2] {
    let half = bodies.orientation[i] * DVec3::Z * (0.5 * length(&bodies.shape[i]));
    [bodies.position[i] - half, bodies.position[i] + half]
}

#[test]
fn daughters_exactly_fill_their_mother() {
    let pose = DQuat::from_axis_angle(DVec3::new(1.0, -0.5, 0.2).normalize(), 1.1);
    let still = Growth::new(0.0, 4.0);
    for mother_length in [4.0, 4.003] {
        let mut bodies = cells(&[(0, mother_length, DVec3::new(1.0, 2.0, 3.0), pose)]);
        bodies.velocity[0] = DVec3::new(0.1, 0.2, -0.3);
        bodies.angular_velocity[0] = DVec3::new(0.4, -0.2, 0.7);
        let [low, high] = tips(&bodies, 0);
        let mut next_id = 1;
        grow(&mut bodies, &still, false, 3, 0.5, 0.01, &mut next_id);
        assert_eq!((bodies.len(), next_id), (2, 3));
        for i in 0..2 {
            assert_eq!(length(&bodies.shape[i]), 0.5 * mother_length);
            let arm = bodies.position[i] - DVec3::new(1.0, 2.0, 3.0);
            let expected = DVec3::new(0.1, 0.2, -0.3) + DVec3::new(0.4, -0.2, 0.7).cross(arm);
            assert!((bodies.velocity[i] - expected).length() < 1e-14);
            let line = bodies.lineage[i];
            assert_eq!((line.id, line.parent, line.birth, line.generation), (1 + i as u64, Some(0), 0.5, 1));
        }
        let (first, second) = (tips(&bodies, 0), tips(&bodies, 1));
        let off = (first[0] - low).length().max((second[1] - high).length()).max((first[1] - second[0]).length());
        println!("tips off by {off:e}");
        assert!(off < 1e-12);
    }
    let mut short = cells(&[(0, 3.999_999, DVec3::ZERO, pose)]);
    let mut next_id = 1;
    grow(&mut short, &GROWTH, false, 3, 0.0, 0.01, &mut next_id);
    assert_eq!(short.len(), 1);
}

#[test]
fn turns_are_small_random_and_depend_on_seed_and_mother_only() {
    let pose = DQuat::from_rotation_y(FRAC_PI_2);
    let divide = |seed: u64, poses: &[(u64, f64, DVec3, DQuat)], id: u64, planar: bool| {
        let mut bodies = cells(poses);
        let mut next_id = 1000;
        grow(&mut bodies, &turning(GROWTH, 2.0), planar, seed, 0.0, 0.0, &mut next_id);
        let daughters: Vec<DQuat> = (0..bodies.len())
            .filter(|i| bodies.lineage[*i].parent == Some(id))
            .map(|i| bodies.orientation[i])
            .collect();
        assert_eq!(daughters.len(), 2);
        daughters
    };
    let cell = |id: u64| (id, 4.0, DVec3::Y * id as f64, pose);
    let alone = divide(5, &[cell(7)], 7, false);
    assert_eq!(alone, divide(5, &[cell(7)], 7, false));
    assert_eq!(alone, divide(5, &[cell(3), cell(9), cell(7), cell(1)], 7, false));
    assert_eq!(alone, divide(5, &[cell(7), cell(9)], 7, false));
    assert_ne!(alone, divide(6, &[cell(7)], 7, false));
    assert_ne!(alone, divide(5, &[cell(8)], 8, false));
    assert_ne!(alone[0], alone[1]);

    let most = 2f64.to_radians();
    for planar in [true, false] {
        let angles: Vec<f64> = (0..400)
            .flat_map(|id| divide(5, &[cell(id)], id, planar))
            .map(|q| {
                let axis = q * DVec3::Z;
                if planar {
                    assert!(axis.z.abs() < 1e-15);
                }
                (axis - pose * DVec3::Z).length()
            })
            .collect();
        let (mean, largest) =
            (angles.iter().sum::<f64>() / 800.0 / most, angles.iter().fold(0.0, |m: f64, a| m.max(*a)) / most);
        println!("planar {planar}: mean |turn| {mean:.3}, largest {largest:.4} of the most");
        assert!((mean - 0.5).abs() < 0.05 && largest <= 1.0 && largest > 0.98, "{mean} {largest}");
    }
}

fn colony(planar: bool, dynamics: serde_json::Value, seed: u64, end: f64) -> Scene {
    parse(&json!({
        "name": "colony", "seed": seed, "planar": planar, "dynamics": dynamics, "time": {"dt": 0.01, "end": end},
        "growth": {"rate": 1.0, "division_length": 4.0, "reorientation_degrees": 0.01},
        "bodies": [body(rod(0.5, 2.0), [0.0; 3], DQuat::from_rotation_y(FRAC_PI_2))]
    }))
}

/// Runs a colony to its end; at every step lengths, counts, lineage, and an audit of overlaps from the bodies alone.
fn grown(scene: Scene, tolerance: f64) -> Simulation {
    let planar = scene.planar;
    let mut simulation = start(scene);
    let (mut length_now, mut generation, mut divisions) = (2.0f64, 0, 0);
    let (mut worst, mut apart, mut recursions) = (0.0f64, 0.0f64, 0);
    let mut known: HashSet<u64> = [0].into();
    while !simulation.done() {
        let step_start = simulation.time();
        let report = simulation.step().unwrap();
        let divided = length_now >= 4.0;
        if divided {
            (length_now, generation, divisions) = (0.5 * length_now, generation + 1, divisions + 1);
        }
        length_now *= 0.01f64.exp();
        let bodies = &simulation.state().unwrap().bodies;
        assert_eq!((bodies.len(), report.bodies), (1 << generation, 1 << generation));
        assert_eq!(report.unconverged, 0, "{report:?}");
        recursions += report.recursions;
        let exact = 2.0 * (report.time.exp()) / f64::from(1 << generation);
        for i in 0..bodies.len() {
            apart = apart.max((length(&bodies.shape[i]) / exact - 1.0).abs());
            let line = bodies.lineage[i];
            assert_eq!(line.generation, generation);
            if divided {
                assert!(known.insert(line.id), "id {} was used before", line.id);
                assert!(known.contains(&line.parent.unwrap()));
                assert_eq!(line.birth, step_start);
            }
            if planar {
                assert_eq!(bodies.position[i].z, 0.0);
                let axis = bodies.orientation[i] * DVec3::Z;
                assert!(axis.z.abs() < 1e-13, "axis leans by {:e}", axis.z);
                assert!(
                    (bodies.velocity[i].z, bodies.angular_velocity[i].x, bodies.angular_velocity[i].y)
                        == (0.0, 0.0, 0.0)
                );
            }
        }
        let audited = contacts(bodies, 0.0).iter().map(|contact| -contact.separation).fold(0.0, f64::max);
        assert!(
            (audited - report.max_overlap).abs() < 1e-12,
            "step {}: {audited:e} against {:e}",
            report.step,
            report.max_overlap
        );
        worst = worst.max(audited);
    }
    println!(
        "{} cells after {divisions} divisions, worst overlap {worst:.2e}, lengths off by {apart:.1e}, {recursions} recursions",
        1 << generation
    );
    assert_eq!(known.len(), (2 << generation) - 1);
    assert!(apart < 1e-12, "lengths are off by {apart:e}");
    assert!(worst <= tolerance, "{worst:e}");
    simulation
}

/// Time after the `k`-th division.
fn after_division(k: u32) -> f64 {
    f64::from(k) * LN_2 + 0.1
}

#[test]
fn a_planar_colony_of_64_holds_its_promises_at_every_step() {
    let simulation = grown(colony(true, json!({"overdamped": {"drag": 1.0}}), 1, after_division(6)), 1e-5);
    assert_eq!(simulation.state().unwrap().bodies.len(), 64);
}

#[test]
fn a_colony_in_space_holds_its_promises_at_every_step() {
    let simulation = grown(colony(false, json!({"overdamped": {"drag": 1.0}}), 1, after_division(6)), 1e-5);
    assert_eq!(simulation.state().unwrap().bodies.len(), 64);
    let out = simulation.state().unwrap().bodies.position.iter().map(|x| x.z.abs()).fold(0.0, f64::max);
    println!("cells leave the plane by {out:e}");
    assert!(out > 1e-9, "the colony never left the line or plane that it began in");
}

#[test]
fn a_colony_with_inertia_holds_its_promises_at_every_step() {
    let simulation = grown(colony(true, json!({"inertial": {"density": 1.0}}), 1, after_division(4)), 1e-5);
    assert_eq!(simulation.state().unwrap().bodies.len(), 16);
}

#[test]
fn a_colony_depends_on_its_seed_alone() {
    let run = |seed| {
        let mut simulation = start(colony(true, json!({"overdamped": {"drag": 1.0}}), seed, after_division(4)));
        while !simulation.done() {
            simulation.step().unwrap();
        }
        simulation.state().unwrap().clone()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1).bodies.position, run(2).bodies.position);
}

/// Scenes that use every kind of memory from step to step: divisions, warm normals, warm multipliers of sub-spheres.
fn scenes_with_memory() -> Vec<Scene> {
    let ellipsoids = |method: serde_json::Value, count: u32, steps: u32| {
        parse(&json!({
            "name": "ellipsoids", "seed": 4, "time": {"dt": 0.1, "end": 0.1 * f64::from(steps)}, "contact": {"method": method},
            "forces": [{"radial_inward": {}}],
            "generate": [{"isotropic": {"count": count, "shape": {"ellipsoid": {"radii": [0.6, 0.6, 1.5]}}, "volume_fraction": 0.15}}]
        }))
    };
    let chainmail = Scene::load("chainmail", ["generate.0.chainmail.columns=4", "time.dt=0.01", "time.end=2"]).unwrap();
    let mut heavy = ellipsoids(json!("relcp"), 600, 5);
    heavy.dynamics = Dynamics::Inertial { density: 0.2, drag: None };
    let mut on_a_floor = ellipsoids(json!("relcp"), 600, 8);
    on_a_floor.walls =
        vec![Wall::HalfSpace { normal: [0.0, 0.0, 1.0], offset: -1.0, motion: None, friction: None, load: None }];
    let midpoint = |mut scene: Scene| {
        scene.time.stepping = Stepping::Midpoint;
        scene
    };
    vec![
        midpoint(colony(true, json!({"overdamped": {"drag": 1.0}}), 1, after_division(4))),
        midpoint(heavy),
        colony(true, json!({"overdamped": {"drag": 1.0}}), 1, after_division(5)),
        crate::colonies::uneven(Stepping::Euler),
        crate::colonies::uneven(Stepping::Midpoint),
        ellipsoids(json!("relcp"), 1100, 8),
        ellipsoids(json!({"multisphere": {"count": 5}}), 600, 8),
        chainmail,
        crate::wall_steps::a_pressed_colony(),
        crate::wall_steps::sub_spheres_in_a_box(),
        on_a_floor,
    ]
}

#[test]
fn a_run_does_not_depend_on_the_number_of_threads() {
    for scene in scenes_with_memory() {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut simulation = start(scene.clone());
                let mut figures = Vec::new();
                while !simulation.done() {
                    let r = simulation.step().unwrap();
                    figures.push((
                        r.constraints,
                        r.recursions,
                        r.iterations,
                        r.max_overlap.to_bits(),
                        r.residual.to_bits(),
                    ));
                }
                (figures, simulation.state().unwrap().clone())
            })
        };
        let one = run(1);
        println!("{}: {} bodies, {} rows", scene.name, one.1.bodies.len(), one.1.warm.len());
        assert!(one.1.warm.iter().any(|w| w.gamma > 0.0), "nothing touches");
        for threads in [2, 3] {
            assert!(one == run(threads), "{}: {threads} threads give other bits", scene.name);
        }
    }
}

#[test]
fn a_run_resumed_midway_ends_with_the_same_bits() {
    for scene in scenes_with_memory() {
        let steps = scene.time.steps();
        let mut whole = start(scene.clone());
        let mut saved: Vec<State> = Vec::new();
        while !whole.done() {
            if [1, steps / 3, steps / 2, steps - 2].contains(&whole.state().unwrap().step) {
                saved.push(whole.state().unwrap().clone());
            }
            whole.step().unwrap();
        }
        for state in saved {
            let from = state.step;
            let mut resumed = Simulation::builder(scene.clone()).resume(state).build().unwrap();
            while !resumed.done() {
                resumed.step().unwrap();
            }
            assert!(
                resumed.state().unwrap() == whole.state().unwrap(),
                "{} resumed at step {from} ends with other bits",
                scene.name
            );
        }
    }
}
