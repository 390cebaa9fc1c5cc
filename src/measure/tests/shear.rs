//! The stress of a sheared cell: of one contact, and against the power dissipated by drag.

use super::*;
use crate::periodic::{Axis, CellShear, Periods, Tilt};
use crate::scene::Scene;
use crate::simulation::{Compute, Simulation};
use serde_json::{Value, json};

fn sheared(name: &str, state: &Snapshot, scene: &Scene) -> Vec<Cell> {
    let (frame, settings) = (Frame::of_scene(scene, "a test".into()), Settings::default());
    select(&[name.into()]).unwrap()[0].of(&View::new(state, &frame, &settings)).unwrap().values
}

#[test]
fn the_stress_of_one_contact_across_the_side_is_its_virial() {
    // The second ball's image one cell up and 1.5 along touches the first one from above and behind.
    let shear = CellShear::new(0.5, Axis::X, Axis::Y);
    let direction = DVec3::new(-0.6, 0.8, 0.0);
    let offset = DVec3::new(1.5, 10.0, 0.0);
    let mut pair = bodies([(BALL, DVec3::ZERO, DQuat::IDENTITY), (BALL, direction - offset, DQuat::IDENTITY)]);
    let tilt = Tilt { direction: shear.direction, gradient: shear.gradient, offset: offset.x };
    pair.periods = Periods::new([Some(8.0), Some(10.0), Some(5.0)]).tilted(tilt);
    let mut frame = frame(false);
    frame.shear = Some((shear, None));
    let state = state(pair, Some(&[([0, 1], 3.0)]));
    let settings = Settings::default();
    let found = select(&["shear_stress".into()]).unwrap()[0].of(&View::new(&state, &frame, &settings)).unwrap();
    let stress = 3.0 * 0.48 / 400.0;
    for (column, expected) in [
        ("shear_strain", 0.35),
        ("shear_stress", stress),
        ("shear_viscosity", stress / 0.5),
        ("normal_difference_1", 3.0 * (0.64 - 0.36) / 400.0),
        ("normal_difference_2", -3.0 * 0.64 / 400.0),
        ("shear_power", 0.5 * 400.0 * stress),
    ] {
        assert_near(value(&found, "shear_stress", column), expected, 1e-14);
    }
    assert_eq!(value(&found, "shear_stress", "shear_dissipation"), None);
    frame.shear = None;
    let LeftOut(reason) =
        select(&["shear_stress".into()]).unwrap()[0].of(&View::new(&state, &frame, &settings)).unwrap_err();
    assert!(reason.contains("periodic.shear"), "{reason}");
}

/// The powers of a run, summed over its steps: of the shear, and of drag.
fn powers(shapes: [Value; 2], dt: f64, mut see: impl FnMut(&[Cell], &Snapshot)) -> [f64; 2] {
    let at = |i: i32, j: i32| {
        let x = 1.5 * (f64::from(i) + 0.5 * f64::from(j % 2)) + 0.02 * f64::from((7 * i + 3 * j) % 5);
        let q = lying(0.6 * f64::from(i * j));
        json!({"shape": shapes[((i + j) % 2) as usize], "position": [x, 1.05 * f64::from(j), 0],
            "orientation": [q.w, q.x, q.y, q.z]})
    };
    let list: Vec<Value> = (0..5).flat_map(|i| (0..6).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    let scene = json!({"name": "sheared", "planar": true, "time": {"dt": dt, "end": 1.5}, "bodies": list,
        "periodic": {"lengths": [7.5, 6.3, null], "shear": {"rate": 0.6, "direction": "x", "gradient": "y"}},
        "dynamics": {"overdamped": {"drag": 1.5}}, "contact": {"overlap_tolerance": 1e-7}});
    let scene = Scene::parse(&scene.to_string(), "test").unwrap();
    let mut simulation = Simulation::builder(scene.clone()).on(&Compute::Cpu).build().unwrap();
    let mut sums = [0.0; 2];
    while !simulation.done() {
        simulation.step().unwrap();
        let state = simulation.state().unwrap().clone();
        let state = Snapshot {
            step: state.step,
            time: simulation.time(),
            bodies: state.bodies,
            warm: Some(state.warm),
            removed: Vec::new(),
            fields: Vec::new(),
        };
        let values = sheared("shear_stress", &state, &scene);
        sums = [sums[0] + dt * values[5].unwrap(), sums[1] + dt * values[6].unwrap()];
        see(&values, &state);
    }
    sums
}

/// The work of the shear on contacts goes into drag relative to the flow, up to a part of the order of the step: a pair
/// that meets within a step moves on to its contact, and forces act along normals that turn in it.
#[test]
fn what_the_shear_does_drag_takes() {
    let ball = json!({"sphere": {"radius": 0.58}});
    let rod = json!({"spherocylinder": {"diameter": 0.7, "length": 1.15}});
    for (name, shapes) in [("balls", [ball.clone(), ball.clone()]), ("balls and rods", [ball, rod])] {
        let off = [0.008, 0.002].map(|dt| {
            let mut worst = 0.0_f64;
            let [done, taken] = powers(shapes.clone(), dt, |values, state| {
                // The sum of gamma n_x l_y, over the contacts of an export.
                let sum: f64 = crate::record::contacts(state, None)
                    .iter()
                    .map(|contact| {
                        let [a, b] = contact.pair.map(|i| state.bodies.position[i]);
                        -contact.gamma * contact.normal.x * (b + contact.shift - a).y
                    })
                    .sum();
                worst = worst.max((sum / (7.5 * 6.3) - values[1].unwrap()).abs());
            });
            println!("{name}, dt {dt}: the shear does {done:.4}, drag takes {taken:.4}");
            assert!(done > 0.1 && worst < 1e-12, "{done} {worst:e}");
            (done / taken - 1.0).abs()
        });
        println!("{name}: off by {:.1e} and {:.1e} with a quarter of the step", off[0], off[1]);
        assert!(off[1] < 0.06 && off[1] < 0.5 * off[0], "{off:?}");
    }
}
