//! What `generate` places in the plane, in a periodic cell, and as founders.

use super::far_apart;
use relcp::bodies::Bodies;
use relcp::scene::{FaultKind, Scene};
use relcp::separation::separation;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use serde_json::{Value, json};

fn scene(rule: Value, more: Value) -> Result<Scene, relcp::scene::SceneError> {
    let mut scene = json!({"name": "placed", "seed": 3, "time": {"dt": 0.01, "end": 0.05}, "generate": [rule]});
    scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    Scene::parse(&scene.to_string(), "placed")
}

fn shapes() -> [Value; 4] {
    [
        json!({"spherocylinder": {"diameter": 0.5, "length": 2}}),
        json!({"ellipsoid": {"radii": [0.4, 0.3, 1]}}),
        json!({"ellipsoid": {"radii": [1, 0.6, 0.3]}}),
        json!({"torus": {"major_radius": 1, "minor_radius": 0.2}}),
    ]
}

fn overlap_free(bodies: &Bodies) {
    far_apart(bodies, |a, b| {
        let [a, b] = bodies.pair(a, b);
        separation(&a, &b, None).unwrap().separation > -1e-12
    });
}

#[test]
fn every_shape_lies_in_the_plane_in_every_direction_without_overlap() {
    for (shape, area) in shapes().into_iter().zip([0.5 * 1.5 + 0.0625 * PI, 0.3 * PI, 0.18 * PI, 0.08 * PI]) {
        let fraction = if shape.get("torus").is_some() { 0.02 } else { 0.15 };
        let rule = json!({"isotropic": {"count": 400, "shape": shape, "volume_fraction": fraction}});
        let placed = scene(rule, json!({"planar": true})).unwrap();
        let bodies = placed.build().unwrap();
        overlap_free(&bodies);
        let side = (400.0 * area / fraction).sqrt();
        let farthest = bodies.position.iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
        assert!(farthest < 0.5 * side && farthest > 0.48 * side, "{farthest} {side}");
        let angle = |q: &glam::DQuat| {
            let axis = *q * glam::DVec3::Z;
            assert!(axis.z.abs() < 1e-15 && (*q * glam::DVec3::X).z < -1.0 + 1e-15, "{axis}");
            axis.y.atan2(axis.x)
        };
        let angles: Vec<f64> = bodies.orientation.iter().map(angle).collect();
        for k in [1.0, 2.0] {
            let mean = |of: fn(f64) -> f64| angles.iter().map(|a| of(k * a)).sum::<f64>() / 400.0;
            // Four standard errors of a uniform cosine, sqrt(1/2 / 400).
            assert!(mean(f64::cos).abs() < 4.0 * 0.0354 && mean(f64::sin).abs() < 4.0 * 0.0354, "{shape} {k}");
        }
        // What a run writes is a planar scene again.
        placed.final_scene(&bodies, 0.0).validate().unwrap();
    }
}

const PI: f64 = std::f64::consts::PI;

#[test]
fn bodies_placed_in_the_plane_run_and_a_force_along_their_axis_is_in_it() {
    let rule = json!({"isotropic": {"count": 30, "shape": shapes()[0], "volume_fraction": 0.3}});
    let more = json!({"planar": true, "forces": [{"propulsion": {"force": 1}}]});
    let mut simulation = Simulation::builder(scene(rule.clone(), more).unwrap()).build().unwrap();
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= 1e-5);
    }
    assert!(simulation.state().unwrap().bodies.position.iter().all(|x| x.z == 0.0));
    let across = json!({"planar": true, "forces": [{"propulsion": {"force": 1, "axis": [1, 0, 0]}}]});
    let error = scene(rule, across).unwrap_err();
    assert!(error.to_string().contains("points out of the plane on bodies that generate.0 places"), "{error}");
}

#[test]
fn a_periodic_cell_needs_no_fraction() {
    for (planar, lengths) in [(true, json!([20, 24, null])), (false, json!([20, 24, 18]))] {
        let rule = json!({"isotropic": {"count": 50, "shape": shapes()[0]}});
        let more = json!({"planar": planar, "periodic": {"lengths": lengths}});
        let without = scene(rule.clone(), more.clone()).unwrap();
        let volume = if planar { 0.75 + 0.0625 * PI } else { 0.0625 * PI * 1.5 + 0.125 * PI / 6.0 };
        let cell = if planar { 480.0 } else { 8640.0 };
        let mut given = rule;
        given["isotropic"]["volume_fraction"] = json!(50.0 * volume / cell);
        let bodies = without.build().unwrap();
        assert_eq!(bodies, scene(given, more).unwrap().build().unwrap());
        assert!(!without.to_json().contains("volume_fraction"));
        assert_eq!(Scene::parse(&without.to_json(), "again").unwrap(), without);
    }
    // A cell that is too full is told by the number.
    let rule = json!({"isotropic": {"count": 300, "shape": shapes()[0]}});
    let error = scene(rule, json!({"planar": true, "periodic": {"lengths": [20, 24, null]}})).unwrap_err();
    assert_eq!(error.key(), "generate.0.isotropic.count");
    assert!(error.to_string().contains("fills 0.591 of the periodic cell"), "{error}");
}

#[test]
fn founders_lie_where_they_are_told_side_by_side() {
    let rule = |more: Value| {
        let mut rule = json!({"founder": {"diameter": 0.5, "length": 2}});
        rule["founder"].as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        rule
    };
    let build = |more: Value| scene(rule(more), json!({})).unwrap().build().unwrap();
    let one = build(json!({}));
    assert_eq!((one.len(), one.position[0]), (1, glam::DVec3::ZERO));
    assert_eq!(one, build(json!({"angle": 0, "count": 1, "position": [0, 0, 0]})));
    let row = build(json!({"angle": 30, "count": 5, "position": [3, -1, 2], "group": "cells"}));
    let middle = glam::DVec3::new(3.0, -1.0, 2.0);
    assert_eq!((row.len(), row.position[2], row.group[4]), (5, middle, 0));
    let axis = glam::DVec3::new(0.75_f64.sqrt(), 0.5, 0.0);
    for (k, (x, q)) in row.position.iter().zip(&row.orientation).enumerate() {
        let across = 0.6 * (k as f64 - 2.0) * glam::DVec3::new(-0.5, 0.75_f64.sqrt(), 0.0);
        assert!((*q * glam::DVec3::Z - axis).length() < 1e-15 && (*x - middle - across).length() < 1e-15);
    }
    let [a, b] = row.pair(1, 2);
    assert!((separation(&a, &b, None).unwrap().separation - 0.1).abs() < 1e-14);
    let ids: Vec<u64> = row.lineage.iter().map(|line| line.id).collect();
    assert_eq!(ids, [0, 1, 2, 3, 4]);
    // A row of them grows in the plane.
    let growth = json!({"planar": true, "growth": {"rate": 1, "division_length": 4}});
    let mut simulation =
        Simulation::builder(scene(rule(json!({"count": 4, "angle": -75})), growth).unwrap()).build().unwrap();
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
    }
    let grown = |shape: &Shape| (shape.major_axis() - 2.0 * 0.05_f64.exp()).abs() < 1e-12;
    assert!(simulation.state().unwrap().bodies.shape.iter().all(grown));
    // And goes not through itself.
    let around = scene(rule(json!({"count": 9})), json!({"periodic": {"lengths": [null, 5, null]}})).unwrap();
    let error = around.build().unwrap_err();
    assert_eq!((error.kind(), error.key()), (FaultKind::Placement, "generate.0.founder"));
    assert!(error.to_string().contains("the row is 5.3"), "{error}");
}

/// A box that does not hold the cube about the origin: refused at once, with what does not fit and what helps.
#[test]
fn a_box_beside_the_origin_is_refused_at_once_in_words() {
    let of = |count: u64, minimum: [f64; 3], maximum: [f64; 3]| {
        let rule = json!({"isotropic": {"count": count, "shape": {"sphere": {"radius": 0.5}}, "volume_fraction": 0.2}});
        scene(rule, json!({"walls": [{"box": {"minimum": minimum, "maximum": maximum}}]})).unwrap()
    };
    for (count, minimum, maximum) in [
        (200, [0.0; 3], [10.0, 10.0, 40.0]),
        (20_000, [-8.0, -8.0, 0.0], [8.0, 8.0, 40.0]),
        (200, [20.0; 3], [40.0; 3]),
    ] {
        // Placement asks after some draws whether it goes on: what is refused at once draws nothing.
        let never = &mut |placed| panic!("drawn, after {placed} bodies");
        let refused = of(count, minimum, maximum).build_while(never).unwrap_err();
        assert_eq!((refused.kind(), refused.key()), (FaultKind::Placement, "generate.0.isotropic.volume_fraction"));
        let said = refused.message();
        assert!(
            said.starts_with(&format!("{count} bodies do not fit: centres are drawn in the cube of side ")),
            "{said}"
        );
        assert!(
            said.contains("inside the walls")
                && refused.help_text().unwrap().contains("`center` to the middle of the walls"),
            "{said}"
        );
    }
    assert_eq!(of(200, [-8.0, -8.0, 0.0], [8.0, 8.0, 40.0]).build().unwrap().len(), 200);
    assert_eq!(of(200, [-5.0; 3], [5.0; 3]).build().unwrap().len(), 200);
}

/// The same box, with the cube in its middle.
#[test]
fn centres_are_drawn_about_the_center_that_is_given() {
    let rule = json!({"isotropic": {"count": 400, "shape": {"sphere": {"radius": 0.5}}, "volume_fraction": 0.2, "center": [5, 5, 20]}});
    let walls = json!({"walls": [{"box": {"minimum": [0, 0, 0], "maximum": [12, 12, 40]}}]});
    let bodies = scene(rule, walls).unwrap().build().unwrap();
    overlap_free(&bodies);
    let side = (400.0 * PI / 6.0 / 0.2).cbrt();
    let off = bodies.position.iter().map(|x| (*x - glam::DVec3::new(5.0, 5.0, 20.0)).abs().max_element());
    let farthest = off.fold(0.0, f64::max);
    assert!(farthest <= 0.5 * side && farthest > 0.48 * side, "{farthest} {side}");
    let planar = json!({"isotropic": {"count": 4, "shape": {"sphere": {"radius": 0.5}}, "volume_fraction": 0.2, "center": [0, 0, 1]}});
    let error = scene(planar, json!({"planar": true})).unwrap_err();
    assert_eq!(error.key(), "generate.0.isotropic.center.2");
}

/// Two rules fill a cube each: the small balls lay inside of the large ones' cube.
#[test]
fn a_mixture_is_mixed_over_one_box() {
    let [small, rod] = [json!({"sphere": {"radius": 0.2}}), json!({"spherocylinder": {"diameter": 0.5, "length": 3}})];
    let rule = json!({"isotropic": {"count": 300, "shape": small, "group": "small", "volume_fraction": 0.1,
        "mixture": [{"count": 200, "shape": {"sphere": {"radius": 0.8}}, "group": "large"}, {"count": 100, "shape": rod}]}});
    for planar in [false, true] {
        let of = scene(rule.clone(), json!({"planar": planar})).unwrap();
        let bodies = of.build().unwrap();
        overlap_free(&bodies);
        // Numbered as listed, each of its shape and its group.
        assert_eq!((bodies.len() as u64, of.body_count()), (600, 600));
        let names = of.group_names();
        let group = |i: usize| names.get(bodies.group[i] as usize).map(String::as_str);
        assert_eq!(
            [0, 299, 300, 499, 500].map(group),
            [Some("small"), Some("small"), Some("large"), Some("large"), None]
        );
        assert!(matches!(bodies.shape[599], Shape::Spherocylinder { .. }));
        let [rod, power] =
            if planar { [0.5 * 2.5 + 0.0625 * PI, 0.5] } else { [bodies.shape[599].volume(), 1.0 / 3.0] };
        let ball = |radius: f64| if planar { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) };
        let side = ((300.0 * ball(0.2) + 200.0 * ball(0.8) + 100.0 * rod) / 0.1_f64).powf(power);
        for component in [0..300, 300..500, 500..600] {
            let far = |x: &glam::DVec3| x.abs().max_element() / (0.5 * side);
            let [mut mean, mut most] = [0.0, 0.0_f64];
            for x in &bodies.position[component.clone()] {
                (mean, most) = (mean + far(x) / component.len() as f64, most.max(far(x)));
            }
            // Of uniform places the mean is 3/4, in the plane 2/3, with a spread of 0.194 and 0.236.
            let [right, spread] = if planar { [2.0 / 3.0, 0.236] } else { [0.75, 0.194] };
            assert!((mean - right).abs() < 4.0 * spread / (component.len() as f64).sqrt(), "{component:?}: {mean}");
            assert!(most <= 1.0 && most > 0.95, "{component:?}: {most}");
        }
    }
    let error = |mixture: Value| {
        let rule = json!({"isotropic": {"count": 3, "shape": {"sphere": {"radius": 1}}, "volume_fraction": 0.1, "mixture": mixture}});
        let error = scene(rule, json!({})).unwrap_err();
        (error.key().to_owned(), error.message().to_owned())
    };
    let ball = |count: u64, radius: f64| json!([{"count": count, "shape": {"sphere": {"radius": radius}}}]);
    assert_eq!(error(ball(0, 1.0)).0, "generate.0.isotropic.mixture.0.count");
    assert_eq!(error(ball(1, -1.0)).0, "generate.0.isotropic.mixture.0.shape.sphere.radius");
    let rods = json!([{"count": 100, "shape": {"spherocylinder": {"diameter": 0.2, "length": 10}}}]);
    let (key, message) = error(rods);
    assert_eq!(key, "generate.0.isotropic.volume_fraction");
    assert!(message.contains("for this mixture"), "{message}");
}
