//! Bodies that `isotropic` places in a region, or inside of the walls.

use super::far_apart;
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::{FaultKind, Scene, SceneError};
use relcp::separation::separation;
use relcp::shape::Shape;
use serde_json::{Value, json};

fn scene(rule: Value, more: Value) -> Result<Scene, SceneError> {
    let mut scene =
        json!({"name": "placed", "seed": 3, "time": {"dt": 0.01, "end": 0.05}, "generate": [{"isotropic": rule}]});
    scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    Scene::parse(&scene.to_string(), "placed")
}

fn rod(count: u64, region: Value) -> Value {
    json!({"count": count, "shape": {"spherocylinder": {"diameter": 0.4, "length": 1.6}}, "region": region})
}

fn overlap_free(bodies: &Bodies) {
    far_apart(bodies, |a, b| {
        let [a, b] = bodies.pair(a, b);
        separation(&a, &b, None).unwrap().separation > -1e-12
    });
}

/// The middles of a rod's caps.
fn caps(bodies: &Bodies, i: usize) -> [DVec3; 2] {
    let half = 0.6 * (bodies.orientation[i] * DVec3::Z);
    [bodies.position[i] - half, bodies.position[i] + half]
}

/// By the caps of rods alone: the placement's own walls are not asked.
fn all_caps(bodies: &Bodies, holds: impl Fn(DVec3) -> bool) {
    for i in 0..bodies.len() {
        assert!(caps(bodies, i).into_iter().all(&holds), "body {i}");
    }
}

#[test]
fn rods_are_wholly_inside_of_a_region_of_any_shape() {
    let build = |region: Value, more: Value| scene(rod(150, region), more).unwrap().build().unwrap();
    let boxed = build(json!({"box": {"minimum": [0, 0, 0], "maximum": [3, 4, 40]}}), json!({}));
    let room = DVec3::new(3.0, 4.0, 40.0) - 0.2;
    all_caps(&boxed, |x| x.cmpge(DVec3::splat(0.2)).all() && x.cmple(room).all());
    overlap_free(&boxed);
    // It is filled from end to end.
    let (low, high) = (0..150)
        .fold((40.0_f64, 0.0_f64), |(low, high), i| (low.min(boxed.position[i].z), high.max(boxed.position[i].z)));
    assert!(low < 2.0 && high > 38.0, "{low} {high}");
    let center = DVec3::new(5.0, -3.0, 7.0);
    let sphere = build(json!({"sphere": {"center": [5, -3, 7], "radius": 4}}), json!({}));
    all_caps(&sphere, |x| x.distance(center) <= 3.8 + 1e-12);
    overlap_free(&sphere);
    let axis = DVec3::new(1.0, 1.0, 1.0).normalize();
    let tube =
        build(json!({"cylinder": {"center": [5, -3, 7], "axis": [1, 1, 1], "radius": 2, "length": 14}}), json!({}));
    all_caps(&tube, |x| {
        let along = (x - center).dot(axis);
        along.abs() <= 6.8 + 1e-12 && (x - center - along * axis).length() <= 1.8 + 1e-12
    });
    overlap_free(&tube);
    // A channel that walls and a period close.
    let walls = json!({"walls": [{"channel": {"normal": [0, 0, 1], "center": [0, 0, 1], "width": 6}}],
        "periodic": {"lengths": [12, null, null]}});
    let slab = build(json!({"channel": {"normal": [0, 1, 0], "center": [0, 2, 0], "width": 5}}), walls);
    all_caps(&slab, |x| (x.y - 2.0).abs() <= 2.3 + 1e-12 && (x.z - 1.0).abs() <= 2.8 + 1e-12);
    assert!(slab.position.iter().all(|x| x.x.abs() <= 6.0));
    far_apart(&slab, |a, b| {
        let [a, b] = slab.pair(a, b);
        let [a, b] = slab.periods.pair(a, b);
        separation(&a, &b, None).unwrap().separation > -1e-12
    });
}

#[test]
fn rods_in_the_plane_are_wholly_inside_of_a_region() {
    let planar = json!({"planar": true});
    let build = |region: Value| scene(rod(60, region), planar.clone()).unwrap().build().unwrap();
    let disc = build(json!({"cylinder": {"center": [9, 9, 0], "axis": [0, 0, 1], "radius": 6}}));
    all_caps(&disc, |x| x.z.abs() < 1e-12 && x.distance(DVec3::new(9.0, 9.0, 0.0)) <= 5.8 + 1e-12);
    overlap_free(&disc);
    let boxed = build(json!({"box": {"minimum": [-20, 3, 5], "maximum": [-8, 10, 6]}}));
    all_caps(&boxed, |x| x.x >= -19.8 && x.x <= -8.2 && x.y >= 3.2 && x.y <= 9.8);
    assert!(boxed.position.iter().all(|x| x.z == 0.0));
    overlap_free(&boxed);
}

/// Small balls in a large sphere: `<r^2> = 3/5 R^2` of the ball that their centres fill, its spread `sqrt(12/175) R^2`.
#[test]
fn centres_are_uniform_in_a_region() {
    let rule = json!({"count": 2000, "shape": {"sphere": {"radius": 0.1}}, "region": {"sphere": {"center": [1, 2, 3], "radius": 10}}});
    let bodies = scene(rule, json!({})).unwrap().build().unwrap();
    let from: Vec<DVec3> = bodies.position.iter().map(|x| *x - DVec3::new(1.0, 2.0, 3.0)).collect();
    let (mean, squares) = from
        .iter()
        .fold((DVec3::ZERO, 0.0), |(mean, squares), x| (mean + *x / 2000.0, squares + x.length_squared() / 2000.0));
    let square = 9.9_f64.powi(2);
    let error = (12.0_f64 / 175.0 / 2000.0).sqrt() * square;
    assert!((squares - 0.6 * square).abs() < 4.0 * error, "{squares} {}", 0.6 * square);
    assert!(mean.abs().max_element() < 4.0 * (0.2 * square / 2000.0).sqrt(), "{mean}");
}

#[test]
fn walls_that_leave_no_way_out_need_no_fraction() {
    let walls = json!({"walls": [{"box": {"minimum": [-4, -4, 0], "maximum": [4, 4, 40]}}]});
    let rule = json!({"count": 1000, "shape": {"sphere": {"radius": 0.5}}});
    let of = scene(rule, walls).unwrap();
    let bodies = of.build().unwrap();
    let room = DVec3::new(3.5, 3.5, 39.5);
    assert!(bodies.position.iter().all(|x| x.cmple(room).all() && x.cmpge(DVec3::new(-3.5, -3.5, 0.5)).all()));
    far_apart(&bodies, |a, b| bodies.position[a].distance(bodies.position[b]) >= 1.0);
    // The same bits from the same seed, and from the scene as it is written.
    assert_eq!(of.build().unwrap(), bodies);
    assert_eq!(Scene::parse(&of.to_json(), "again").unwrap().build().unwrap(), bodies);
    let mut other = of;
    other.seed = 4;
    assert_ne!(other.build().unwrap().position, bodies.position);
}

#[test]
fn two_sizes_are_mixed_in_one_region_with_a_group_each() {
    let rule = json!({"count": 400, "shape": {"sphere": {"radius": 0.25}}, "group": "small",
        "mixture": [{"count": 60, "shape": {"sphere": {"radius": 0.5}}, "group": "large"}],
        "region": {"box": {"minimum": [10, 0, 0], "maximum": [18, 8, 8]}}});
    let of = scene(rule, json!({})).unwrap();
    let bodies = of.build().unwrap();
    assert_eq!(of.group_names(), ["small", "large"]);
    far_apart(&bodies, |a, b| {
        let radius = |i: usize| if i < 400 { 0.25 } else { 0.5 };
        bodies.position[a].distance(bodies.position[b]) >= radius(a) + radius(b)
    });
    for (component, radius) in [(0..400, 0.25), (400..460, 0.5)] {
        let mean = bodies.position[component.clone()].iter().sum::<DVec3>() / component.len() as f64;
        let spread = (8.0 - 2.0 * radius) / 12.0_f64.sqrt() / (component.len() as f64).sqrt();
        assert!((mean - DVec3::new(14.0, 4.0, 4.0)).abs().max_element() < 4.0 * spread, "{mean}");
        assert!(bodies.shape[component.start] == Shape::Sphere { radius });
    }
}

/// The mean of `2 b / l^2` from `b` to `2 b` is `2 b ln 2`.
#[test]
fn lengths_of_rods_have_their_distribution() {
    let rod = json!({"spherocylinder": {"diameter": 0.4, "length": 1}});
    let rule = json!({"count": 200, "shape": rod, "lengths": {"dividing": {"birth": 1}}, "group": "cells",
        "mixture": [{"count": 100, "shape": rod, "lengths": {"uniform": {"from": 0.4, "to": 2.4}}}],
        "region": {"box": {"minimum": [0, 0, 0], "maximum": [20, 20, 1]}}});
    let of = scene(rule, json!({"planar": true})).unwrap();
    let bodies = of.build().unwrap();
    overlap_free(&bodies);
    assert_eq!((bodies.len() as u64, of.body_count()), (300, 300));
    let lengths: Vec<f64> = bodies.shape.iter().map(Shape::major_axis).collect();
    let mean = lengths[..200].iter().sum::<f64>() / 200.0;
    assert!((mean - 2.0 * std::f64::consts::LN_2).abs() < 1e-4, "{mean}");
    let mean = lengths[200..].iter().sum::<f64>() / 100.0;
    assert!((mean - 1.4).abs() < 1e-12 && lengths[200..].iter().all(|length| (0.41..=2.39).contains(length)), "{mean}");
    let group = |i: usize| of.group_names().get(bodies.group[i] as usize).cloned();
    assert_eq!([group(199), group(200)], [Some("cells".to_owned()), None]);
    assert_eq!(Scene::parse(&of.to_json(), "again").unwrap().build().unwrap(), bodies);
    let fault = |shape: Value, lengths: Value| {
        let rule = json!({"count": 2, "shape": shape, "lengths": lengths, "volume_fraction": 0.1});
        let error = scene(rule, json!({})).unwrap_err();
        error.key().strip_prefix("generate.0.isotropic.lengths").unwrap_or("elsewhere").to_owned()
    };
    assert_eq!(fault(rod.clone(), json!({"uniform": {"from": 0.3, "to": 1}})), ".uniform.from");
    assert_eq!(fault(rod.clone(), json!({"uniform": {"from": 2, "to": 1}})), ".uniform.to");
    assert_eq!(fault(rod.clone(), json!({"dividing": {"birth": -1}})), ".dividing.birth");
    assert_eq!(fault(rod, json!({"dividing": {"mean": 1}})), ".dividing.mean");
    assert_eq!(fault(json!({"sphere": {"radius": 1}}), json!({"dividing": {"birth": 1}})), "");
    // So many that their list would not fit into memory.
    let many = json!({"count": u64::MAX, "shape": {"spherocylinder": {"diameter": 0.4, "length": 1}},
        "lengths": {"dividing": {"birth": 1}}, "volume_fraction": 0.1});
    assert_eq!(scene(many, json!({})).unwrap_err().kind(), FaultKind::TooLarge);
}

#[test]
fn what_does_not_fit_is_refused_with_the_number_that_was_placed() {
    let boxed = json!({"box": {"minimum": [0, 0, 0], "maximum": [5, 5, 5]}});
    let of = |count: u64| {
        let rule = json!({"count": count, "shape": {"sphere": {"radius": 0.5}}, "region": boxed});
        scene(rule, json!({})).unwrap().build()
    };
    // 4^3 of 5^3 are free to centres: 50 balls fill 41 % of that; jammed, random placement ends at about 38 %.
    assert_eq!(of(40).unwrap().len(), 40);
    let error = of(90).unwrap_err();
    assert_eq!((error.kind(), error.key()), (FaultKind::Placement, "generate.0.isotropic.count"));
    let words = error.message();
    assert!(words.contains(" of 90 bodies were placed; no free place was found for the next"), "{words}");
    assert!(error.help_text().unwrap().contains("make `region` larger"));
    let error = of(500).unwrap_err();
    assert!(error.message().starts_with("500 bodies do not fit"), "{}", error.message());
    assert!(error.message().contains("volume 125"), "{}", error.message());
}

#[test]
fn a_region_that_makes_no_sense_is_refused_with_its_key() {
    let boxed = json!({"box": {"minimum": [0, 0, 0], "maximum": [5, 5, 5]}});
    let fault = |rule: Value, more: Value| {
        let error = scene(rule, more).unwrap_err();
        (error.key().to_owned(), error.message().to_owned())
    };
    let with = |more: Value| {
        let mut rule = rod(3, boxed.clone());
        rule.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        rule
    };
    let place = |name: &str| format!("generate.0.isotropic.{name}");
    let (key, words) = fault(with(json!({"volume_fraction": 0.1})), json!({}));
    assert!(key == place("volume_fraction") && words.starts_with("conflicts with `region`"), "{key} {words}");
    let (key, words) = fault(with(json!({"center": [1, 0, 0]})), json!({}));
    assert!(key == place("center") && words.contains("omit it"), "{key} {words}");
    let open = json!({"half_space": {"normal": [0, 0, 1], "offset": 0}});
    let (key, words) = fault(rod(3, open), json!({}));
    assert!(key == place("region.half_space") && words.contains("way out"), "{key} {words}");
    let moving = json!({"sphere": {"center": [0, 0, 0], "radius": 3, "motion": {"velocity": [1, 0, 0]}}});
    assert_eq!(fault(rod(3, moving), json!({})).0, place("region.sphere.motion"));
    let small = json!({"sphere": {"center": [0, 0, 0], "radius": -3}});
    assert_eq!(fault(rod(3, small), json!({})).0, place("region.sphere.radius"));
    let tilted = json!({"half_space": {"normal": [0, 1, 1], "offset": 0}});
    assert_eq!(fault(rod(3, tilted), json!({"planar": true})).0, place("region.half_space.normal.2"));
    // Walls that leave a way out do not say how densely bodies lie.
    let rule = json!({"count": 3, "shape": {"sphere": {"radius": 0.5}}});
    let channel = json!({"walls": [{"channel": {"normal": [0, 1, 0], "center": [0, 0, 0], "width": 6}}]});
    let (key, words) = fault(rule, channel);
    assert!(key == place("volume_fraction") && words.starts_with("is missing; only"), "{key} {words}");
    // A region outside of the walls.
    let walls = json!({"walls": [{"box": {"minimum": [7, 7, 7], "maximum": [9, 9, 9]}}]});
    let error = scene(rod(3, boxed), walls).unwrap().build().unwrap_err();
    assert_eq!(error.key(), place("region"));
    assert!(error.message().contains("no inside in common"), "{}", error.message());
}
