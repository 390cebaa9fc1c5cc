//! Ellipsoids that grow and divide: their lengths, radii and numbers, daughters inside of their mothers, crowds.

use crate::scenes::{agrees_on_device, parse, refusal, run, watch};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::internals::dynamics::{Cells, Waiting, stretch};
use relcp::scene::{GrowingShape, Growth};
use relcp::separation::{Placed, separation};
use relcp::shape::Shape;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};
use std::f64::consts::{LN_2, PI};

fn species(growth: Growth) -> Growth {
    let mut growth = growth;
    growth.shape = GrowingShape::Ellipsoid;
    growth
}

fn radii(shape: &Shape) -> DVec3 {
    match *shape {
        Shape::Ellipsoid { radii } => radii.into(),
        _ => panic!("{shape:?} is no ellipsoid"),
    }
}

/// A founder in the plane, which is as long as a daughter of a mother of length 2 and has these radii at its tips.
fn colony(tip: f64, growth: &Value, more: &Value) -> Value {
    let across = (0.5 * tip).sqrt();
    let mut own = json!({"shape": "ellipsoid", "rate": 1, "division_length": 2, "division_length_noise": 0.1,
                         "rate_noise": 0.1, "reorientation_degrees": 5});
    let mut scene = json!({"name": "ellipsoids", "planar": true, "seed": 3, "time": {"dt": 0.01, "end": 5},
        "bodies": [{"shape": {"ellipsoid": {"radii": [across, across, 0.5]}}, "position": [0, 0, 0], "angle": 20}]});
    own.as_object_mut().unwrap().extend(growth.as_object().unwrap().clone());
    scene["growth"] = own;
    scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    scene
}

#[test]
fn a_single_ellipsoid_grows_as_the_closed_form() {
    let start = DVec3::new(0.3, 0.5, 0.8);
    let scene = json!({"name": "one", "time": {"dt": 0.01, "end": 1}, "growth": {"shape": "ellipsoid", "rate": 1.2,
        "division_length": 9}, "bodies": [{"shape": {"ellipsoid": {"radii": start.to_array()}}, "position": [0, 0, 0]}]});
    let mut time = 0.0;
    watch(&scene, |bodies| {
        let factor = (1.2_f64 * time).exp();
        let expected = start * DVec3::new(factor.sqrt(), factor.sqrt(), factor);
        assert!((radii(&bodies.shape[0]) / expected - 1.0).abs().max_element() < 3e-14, "{time}");
        time += 0.01;
    });
}

/// The radii of curvature of all cells' tips are their founder's, their lengths add up to `L e^(rate t)`, and there are
/// `2^k` of them; on devices too, and what is resumed has the same bits.
#[test]
fn lengths_and_tips_are_kept_and_numbers_double() {
    for more in [json!({}), json!({"time": {"dt": 0.01, "end": 3.3, "stepping": "midpoint"}})] {
        let growth = json!({"division_length_noise": 0, "rate_noise": 0});
        let mut scene = colony(0.16, &growth, &json!({"time": {"dt": 0.01, "end": 3.3}}));
        scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let scene = parse(&scene);
        let state = run(scene.clone(), &Compute::Cpu);
        let doublings = ((3.29 - LN_2) / LN_2).floor() + 1.0;
        assert_eq!(state.bodies.len() as f64, doublings.exp2());
        let length: f64 = state.bodies.shape.iter().filter_map(Shape::growing_length).sum();
        assert!((length / 3.3_f64.exp() - 1.0).abs() < 1e-12, "{length}");
        for shape in &state.bodies.shape {
            let radii = radii(shape);
            assert!((radii.truncate() * radii.truncate() / radii.z / 0.16 - 1.0).abs().max_element() < 3e-14);
        }
        agrees_on_device(&scene, "ellipsoids", [2e-3, 1e-9]);
    }
}

fn random_pose(random: &mut impl RngExt, reach: f64) -> (DVec3, DQuat) {
    let mut draw = |most: f64| random.random_range(-most..most);
    (DVec3::from_array([(); 3].map(|()| draw(reach))), DQuat::from_array([(); 4].map(|()| draw(1.0))).normalize())
}

/// By brute force over points of the daughters' surfaces, in the mother's axes; and both daughters only touch.
#[test]
fn daughters_lie_in_their_mother_and_do_not_overlap() {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    for mother in 0..200 {
        let long = random.random_range(0.2..5.0);
        let most = long * 0.5_f64.sqrt();
        let [x, y] = [(); 2].map(|()| random.random_range(0.05 * most..most));
        let shape = Shape::Ellipsoid { radii: [x, y, long] };
        let (position, orientation) = random_pose(&mut random, 10.0);
        let mut bodies = Bodies::default();
        bodies.push(Placed { shape, position, orientation }, NO_GROUP);
        let cells = Cells::new(&[species(Growth::new(1.0, 2.0 * long * 0.999))], &[], false, mother);
        cells.divide(&mut bodies, (0.0, 1.0), &mut 1, &mut Vec::new(), &Waiting::None);
        assert_eq!(bodies.len(), 2);
        for daughter in 0..2 {
            let own = radii(&bodies.shape[daughter]);
            assert!((own.z / long - 0.5).abs() < 1e-15);
            for _ in 0..500 {
                let at = random_pose(&mut random, 1.0).1 * DVec3::Z * own;
                let point = bodies.position[daughter] + bodies.orientation[daughter] * at;
                let inside = (orientation.inverse() * (point - position) / radii(&shape)).length();
                assert!(inside < 1.0 + 1e-12, "{mother}: {inside}");
            }
        }
        let found = separation(&bodies.placed(0), &bodies.placed(1), None).unwrap();
        assert!(found.separation.abs() < 1e-12 * long, "{mother}: {}", found.separation);
    }
}

/// The change of a separation with the lengths of both bodies, against a difference of separations.
#[test]
fn surfaces_move_as_separations_change() {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(2);
    let draw = |random: &mut rand_chacha::ChaCha8Rng, reach| {
        let (position, orientation) = random_pose(random, reach);
        let shape = Shape::Ellipsoid { radii: [random.random_range(0.2..0.9), random.random_range(0.2..0.9), 1.0] };
        Placed { shape, position, orientation }
    };
    for _ in 0..100 {
        let (a, mut b) = (draw(&mut random, 0.1), draw(&mut random, 1.0));
        b.position = 2.5 * b.position.normalize();
        let [longer, shorter] = [1.0, -1.0]
            .map(|sign| [&a, &b].map(|of| Placed { shape: of.shape.grown(2.0 * (1.0 + sign * 1e-4)).unwrap(), ..*of }));
        let separate = |[a, b]: &[Placed; 2]| separation(a, b, None).unwrap();
        let (found, change) = (separate(&[a, b]), 0.5 * (separate(&longer).separation - separate(&shorter).separation));
        let of_a = stretch(&a, &longer[0].shape, found.lever_a, found.normal);
        let of_b = stretch(&b, &longer[1].shape, found.lever_b, -found.normal);
        let expected = found.normal.dot(of_b - of_a);
        assert!((change - expected).abs() < 1e-7, "{change} {expected}");
        assert!(expected < 0.0);
    }
}

/// Crowds hold contact, and move by small parts of a cell in a step.
#[test]
fn colonies_grow_without_overlap() {
    let disc = json!([{"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 5}}]);
    let kinds = [
        ("born as balls", 0.4, json!({"stop": {"population": 150}}), json!({})),
        ("long", 0.04, json!({"stop": {"population": 150}}), json!({})),
        ("confined", 0.12, json!({"on_no_room": "stall", "stress_sensitivity": 0.1}), json!({"walls": disc})),
        ("space", 0.12, json!({"stop": {"population": 100}}), json!({"planar": false})),
    ];
    for (name, tip, growth, more) in kinds {
        let mut scene = colony(tip, &growth, &more);
        scene["time"]["end"] = json!(6);
        if name == "space" {
            scene["bodies"][0].as_object_mut().unwrap().remove("angle");
        }
        let mut simulation = Simulation::new(parse(&scene)).unwrap();
        let (mut moved, mut overlap) = (0.0_f64, 0.0_f64);
        while !simulation.done() {
            let report = simulation.step().unwrap();
            moved = moved.max(report.largest_move);
            overlap = overlap.max(report.max_overlap);
        }
        let bodies = simulation.state().unwrap().bodies.len();
        println!("{name}: {bodies} bodies, largest move {moved:.3}, overlap {overlap:.1e}");
        assert!(bodies >= 100 && overlap <= 1e-5 && moved < 0.25, "{name}: {bodies} {moved} {overlap:e}");
    }
}

/// Cells that eat in a channel between walls whose ends are periodic, with drag of real bodies, on devices and resumed.
#[test]
fn a_fed_crowd_agrees_on_a_device_and_goes_on_with_the_same_bits() {
    let growth = json!({"nutrient": {"field": "food", "half": 0.2}, "stress_sensitivity": 0.02, "rule": "adder",
                        "division_length": null, "division_length_noise": 0, "added_length": 1});
    let more = json!({"time": {"dt": 0.02, "end": 4}, "periodic": {"lengths": [10, null, null]},
        "dynamics": {"overdamped": {"drag": {"viscosity": 0.3}}},
        "walls": [{"half_space": {"normal": [0, 1, 0], "offset": -2}},
                  {"half_space": {"normal": [0, -1, 0], "offset": -2}}],
        "fields": {"food": {"cells": [10, 4, 1], "spacing": 1, "diffusion": 1, "initial": 1,
                            "exchange": [{"uptake": 0.3, "half": 0.2}]}}});
    agrees_on_device(&parse(&colony(0.2, &growth, &more)), "fed ellipsoids", [5e-3, 1e-7]);
}

/// Uptake by an ellipsoid has its second moment along the axis: `z^2 / 5` in space, `z^2 / 4` in the plane.
#[test]
fn uptake_is_spread_along_an_ellipsoid() {
    for (planar, part) in [(true, 4.0), (false, 5.0)] {
        let along = if planar { json!([1, 0, 0]) } else { json!([0, 0, 1]) };
        let cells = if planar { [161, 9, 1] } else { [9, 9, 161] };
        let scene = json!({"name": "spread", "planar": planar, "time": {"dt": 0.01, "end": 0.01},
            "growth": {"shape": "ellipsoid", "rate": 0, "division_length": 9},
            "fields": {"food": {"cells": cells, "spacing": 0.05, "diffusion": 0, "initial": 1e6,
                                "exchange": [{"uptake": 1, "half": 1e-3}]}},
            "bodies": [{"shape": {"ellipsoid": {"radii": [0.2, 0.2, 2]}}, "position": [0, 0, 0], "axis": along}]});
        let state = run(parse(&scene), &Compute::Cpu);
        let field = &state.fields[0];
        let k = if planar { 0 } else { 2 };
        let (mut eaten, mut moment) = (0.0, 0.0);
        for (cell, value) in field.values.iter().enumerate() {
            let amount = 1e6 - value;
            eaten += amount;
            moment += amount * field.grid.center_of(cell)[k].powi(2);
        }
        let second = moment / eaten;
        assert!((second * part / 4.0 - 1.0).abs() < 5e-3, "{planar}: {second}");
    }
}

/// The pressure of an ellipsoid that is pressed onto a wall: the force times its distance, over its size and the
/// dimension. With a sensitivity of `s` its rate is that times `e^(-s p)`.
#[test]
fn a_squeezed_ellipsoid_grows_by_its_pressure() {
    for planar in [true, false] {
        let wall = json!({"half_space": {"normal": [0, 1, 0], "offset": -0.5}});
        let along = json!([1, 0, 0]);
        let scene = json!({"name": "squeezed", "planar": planar, "time": {"dt": 0.001, "end": 0.02},
            "contact": {"overlap_tolerance": 1e-7, "on_failure": "continue"}, "solver": {"tolerance": 1e-10},
            "growth": {"shape": "ellipsoid", "rate": 0.1, "division_length": 9, "stress_sensitivity": 1e-3},
            "forces": [{"uniform": {"force": [0, -50, 0]}}], "walls": [wall],
            "bodies": [{"shape": {"ellipsoid": {"radii": [0.5, 0.5, 1]}}, "position": [0, 0, 0], "axis": along}]});
        let state = run(parse(&scene), &Compute::Cpu);
        let length = state.bodies.shape[0].growing_length().unwrap();
        // One wall carries the load of 50: a virial of 50 times the half width, over twice the area or thrice the
        // volume. Twice the area, pi / 2, and thrice the volume, pi / 3, are equal here.
        let size = PI;
        let pressure = 50.0 * 0.5 / size;
        let rate = 0.1 * (-1e-3 * pressure).exp();
        let grown = (length / 2.0).ln() / 0.02;
        // The first step has no pressure yet, and growth changes it by some thousandths.
        let expected = (0.1 + 19.0 * rate) / 20.0;
        assert!((grown / expected - 1.0).abs() < 1e-4, "{planar}: {grown} {expected}");
        assert!((grown / 0.1 - 1.0).abs() > 5e-3);
    }
}

#[test]
fn what_cannot_grow_is_refused() {
    let bodies = |radii: Value| json!([{"shape": {"ellipsoid": {"radii": radii}}, "position": [0, 0, 0], "angle": 0}]);
    let flat = colony(0.2, &json!({}), &json!({"bodies": bodies(json!([0.5, 0.5, 0.4]))}));
    let (key, message) = refusal(&flat);
    assert!(key == "bodies.0.shape" && message.contains("must be the largest"), "{key} {message}");
    let fixed = colony(0.2, &json!({}), &json!({"groups": {"a": {"fixed": true}}}));
    let mut fixed = fixed;
    fixed["bodies"][0]["group"] = json!("a");
    let (key, message) = refusal(&fixed);
    assert!(key == "bodies.0.shape" && message.contains("would grow"), "{key} {message}");
    let (key, message) = refusal(&colony(0.45, &json!({"division_length": 1.7}), &json!({})));
    assert!(key == "growth.division_length" && message.contains("the tips of bodies.0"), "{key} {message}");
    let (key, message) = refusal(&colony(0.2, &json!({"shape": "spherocylinder"}), &json!({})));
    assert!(key == "growth" && message.contains("with \"shape\": \"ellipsoid\" ellipsoids do"), "{key} {message}");
    let (key, message) = refusal(&colony(0.2, &json!({"shape": "ball"}), &json!({})));
    assert!(key == "growth.shape", "{key} {message}");
}

/// An entry for rods leaves ellipsoids as they are, and one for ellipsoids rods.
#[test]
fn other_shapes_of_the_species_do_not_grow() {
    for (shape, grows) in [("spherocylinder", 0), ("ellipsoid", 1)] {
        let scene = json!({"name": "two", "time": {"dt": 0.01, "end": 0.5},
            "growth": {"shape": shape, "rate": 1, "division_length": 9}, "bodies": [
                {"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "position": [-5, 0, 0]},
                {"shape": {"ellipsoid": {"radii": [0.5, 0.5, 1]}}, "position": [5, 0, 0]}]});
        let scene = parse(&scene);
        let state = run(scene.clone(), &Compute::Cpu);
        for (body, shape) in state.bodies.shape.iter().enumerate() {
            let expected = if body == grows { 2.0 * 0.5_f64.exp() } else { 2.0 };
            assert!((shape.growing_length().unwrap() / expected - 1.0).abs() < 1e-12, "{body}");
        }
        agrees_on_device(&scene, shape, [1e-5, 1e-12]);
    }
}
