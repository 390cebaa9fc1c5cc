//! Bodies on a lattice.

use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::{FaultKind, Generate, Lattice, LatticeKind, Scene, SceneError, Time};
use relcp::shape::Shape;
use serde_json::{Value, json};

fn scene(rule: Value, more: Value) -> Result<Scene, SceneError> {
    let mut scene =
        json!({"name": "placed", "seed": 3, "time": {"dt": 0.01, "end": 0.05}, "generate": [{"lattice": rule}]});
    scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    Scene::parse(&scene.to_string(), "placed")
}

fn balls(kind: &str, counts: [u64; 3]) -> Bodies {
    let rule = json!({"kind": kind, "shape": {"sphere": {"radius": 0.5}}, "spacing": 1.5, "counts": counts, "center": [1, 2, 3]});
    scene(rule, json!({})).unwrap().build().unwrap()
}

/// The number of pairs at the spacing. Asserts that no pair is closer.
fn neighbours(bodies: &Bodies) -> usize {
    let mut count = 0;
    for a in 0..bodies.len() {
        for b in a + 1..bodies.len() {
            let distance = bodies.position[a].distance(bodies.position[b]);
            assert!(distance > 1.5 - 1e-12, "{distance}");
            count += usize::from(distance < 1.5 + 1e-12);
        }
    }
    count
}

#[test]
fn lattices_have_their_spacing_their_neighbours_and_their_middle() {
    for (kind, counts, pairs) in [
        ("square", [4, 5, 1], 3 * 5 + 4 * 4),
        ("hexagonal", [4, 5, 1], 3 * 5 + (2 * 4 - 1) * 4),
        ("cubic", [3, 4, 5], 2 * 4 * 5 + 3 * 3 * 5 + 3 * 4 * 4),
        ("cubic", [1, 1, 1], 0),
        ("hexagonal", [6, 1, 1], 5),
    ] {
        let bodies = balls(kind, counts);
        assert_eq!(bodies.len() as u64, counts.iter().product::<u64>());
        assert_eq!(neighbours(&bodies), pairs, "{kind}");
        let low = bodies.position.iter().copied().reduce(DVec3::min).unwrap();
        let high = bodies.position.iter().copied().reduce(DVec3::max).unwrap();
        assert!((0.5 * (low + high) - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-12, "{kind} {low} {high}");
    }
}

/// 515 points of whole coordinates are within 5 of the origin, 81 in the plane; and a hexagon of rings about its
/// middle, 1, 6, 12 and so on, is in a disc.
#[test]
fn a_lattice_fills_its_region() {
    let build = |kind: &str, region: Value, more: Value| {
        let rule = json!({"kind": kind, "shape": {"sphere": {"radius": 0.25}}, "spacing": 1, "region": region});
        let of = scene(rule, more).unwrap();
        let bodies = of.build().unwrap();
        assert_eq!(bodies.len() as u64, of.body_count());
        bodies
    };
    let sphere = build("cubic", json!({"sphere": {"center": [3, 4, 5.5], "radius": 5.3}}), json!({}));
    assert_eq!(sphere.len(), 515);
    assert!(sphere.position.iter().all(|x| x.distance(DVec3::new(3.0, 4.0, 5.5)) <= 5.05));
    let disc = json!({"cylinder": {"center": [3, 4, 0], "axis": [0, 0, 1], "radius": 5.3}});
    assert_eq!(build("square", disc.clone(), json!({"planar": true})).len(), 81);
    // 1 + 6 + 6 + 6 + 12 + 6 + ... sites of a triangular lattice within 5: 91, those of norm up to 25.
    let within = |most: i64| {
        let norms = (-9..=9_i64).flat_map(|a| (-9..=9_i64).map(move |b| a * a + a * b + b * b));
        norms.filter(|norm| *norm <= most).count()
    };
    assert_eq!(build("hexagonal", disc, json!({"planar": true})).len(), within(25));
    // A box holds floor(width / spacing) + 1 in each direction, about a site in its middle.
    let boxed = json!({"box": {"minimum": [0, 0, 0], "maximum": [10.6, 4.6, 2.6]}});
    assert_eq!(build("cubic", boxed.clone(), json!({})).len(), 11 * 5 * 3);
    // A sheet in space at the height of its center.
    let sheet = json!({"kind": "square", "shape": {"sphere": {"radius": 0.25}}, "spacing": 1, "region": boxed, "center": [0.5, 0.5, 1]});
    let bodies = scene(sheet, json!({})).unwrap().build().unwrap();
    assert_eq!(bodies.len(), 10 * 4);
    assert!(bodies.position.iter().all(|x| x.z == 1.0 && x.x.fract() == 0.5));
}

#[test]
fn bodies_of_a_lattice_lie_as_they_are_told() {
    let rod = json!({"spherocylinder": {"diameter": 0.2, "length": 1.2}});
    let build = |more: Value, scene_keys: Value| {
        let mut rule = json!({"kind": "square", "shape": rod, "spacing": 1.5, "counts": [12, 12, 1], "group": "rods"});
        rule.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        scene(rule, scene_keys).unwrap().build().unwrap()
    };
    let axes = |bodies: &Bodies| bodies.orientation.iter().map(|q| *q * DVec3::Z).collect::<Vec<_>>();
    let near = |axis: &DVec3, to: DVec3| (*axis - to).length() < 1e-12;
    assert!(axes(&build(json!({}), json!({}))).iter().all(|axis| near(axis, DVec3::X)));
    assert!(
        axes(&build(json!({"axis": [0, 3, 4]}), json!({}))).iter().all(|axis| near(axis, DVec3::new(0.0, 0.6, 0.8)))
    );
    let planar = json!({"planar": true});
    let tilted = DVec3::new(0.75_f64.sqrt(), 0.5, 0.0);
    assert!(axes(&build(json!({"angle": 30}), planar.clone())).iter().all(|axis| near(axis, tilted)));
    let random = build(json!({"random": true}), planar);
    assert!(axes(&random).iter().all(|axis| axis.z.abs() < 1e-12));
    let doubled = axes(&random).iter().map(|axis| axis.x * axis.x - axis.y * axis.y).sum::<f64>() / 144.0;
    assert!(doubled.abs() < 4.0 * (0.5_f64 / 144.0).sqrt(), "{doubled}");
    assert_eq!(random, build(json!({"random": true}), json!({"planar": true})));
    let space = build(json!({"random": true}), json!({}));
    let square = axes(&space).iter().map(|axis| axis.z * axis.z).sum::<f64>() / 144.0;
    assert!((square - 1.0 / 3.0).abs() < 4.0 * (4.0_f64 / 45.0 / 144.0).sqrt(), "{square}");
    assert_ne!(space.orientation[0], space.orientation[1]);
}

#[test]
fn lattices_in_code_are_those_of_files() {
    let mut of = Scene::new("code", Time::new(0.01, 1.0));
    let ball = Shape::Sphere { radius: 0.5 };
    of.generate = vec![Generate::Lattice(Lattice::new(LatticeKind::Hexagonal, ball, 1.5, [4, 5, 1]))];
    let bodies = of.build().unwrap();
    assert_eq!(bodies.len(), 20);
    assert_eq!(Scene::parse(&of.to_json(), "file").unwrap().build().unwrap(), bodies);
    let last = of.final_scene(&bodies, 0.0);
    assert_eq!(Scene::parse(&last.to_json(), "final").unwrap().build().unwrap(), bodies);
}

#[test]
fn a_lattice_that_makes_no_sense_is_refused_with_its_key() {
    let good = json!({"kind": "square", "shape": {"sphere": {"radius": 0.5}}, "spacing": 1.5, "counts": [4, 5, 1]});
    let fault = |more: Value, keys: Value| {
        let mut rule = good.clone();
        rule.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let error = scene(rule, keys).and_then(|of| of.build()).unwrap_err();
        let (key, words) = (error.key().to_owned(), error.message().to_owned());
        (error.kind(), key.strip_prefix("generate.0.lattice.").unwrap_or(&key).to_owned(), words)
    };
    let boxed = json!({"box": {"minimum": [0, 0, 0], "maximum": [5, 5, 5]}});
    for (more, kind, key, says) in [
        (json!({"spacing": 0.9}), FaultKind::Placement, "spacing", "overlap each other by up to 0.1"),
        (json!({"spacing": 0}), FaultKind::BadValue, "spacing", "must be positive"),
        (json!({"counts": [4, 0, 1]}), FaultKind::BadValue, "counts.1", "at least 1"),
        (json!({"counts": [4, 5, 2]}), FaultKind::BadValue, "counts.2", "a sheet"),
        (json!({"counts": [4000000, 5000000, 1]}), FaultKind::TooLarge, "generate.0.lattice", "bodies; at most"),
        (json!({"region": boxed}), FaultKind::BadValue, "region", "conflicts with `counts`"),
        (json!({"counts": null}), FaultKind::MissingKey, "counts", "and `region` too"),
        (json!({"axis": [0, 0, 0]}), FaultKind::BadValue, "axis", "direction"),
        (json!({"axis": [0, 0, 1], "random": true}), FaultKind::BadValue, "random", "conflicts with `axis`"),
        (json!({"angle": 20}), FaultKind::BadValue, "angle", "in space, give `axis`"),
        (json!({"shape": {"sphere": {"radius": -1}}}), FaultKind::BadValue, "shape.sphere.radius", "positive"),
        (json!({"kind": "round"}), FaultKind::BadValue, "kind", "unknown value `round`"),
    ] {
        let (found, place, words) = fault(more.clone(), json!({}));
        assert!(found == kind && place == key && words.contains(says), "{more}: {found:?} {place}: {words}");
    }
    let open = json!({"counts": null, "region": {"channel": {"normal": [0, 1, 0], "center": [0, 0, 0], "width": 5}}});
    assert!(fault(open, json!({})).2.contains("must be closed"));
    let narrow = json!({"counts": null, "region": {"sphere": {"center": [0, 0, 0], "radius": 0.4}}});
    assert_eq!(fault(narrow, json!({})).1, "region");
    let planar = json!({"planar": true});
    assert_eq!(fault(json!({"kind": "cubic"}), planar.clone()).1, "kind");
    assert_eq!(fault(json!({"center": [0, 0, 1]}), planar.clone()).1, "center.2");
    let rod = json!({"spherocylinder": {"diameter": 0.2, "length": 1.2}});
    assert_eq!(fault(json!({"shape": rod, "axis": [0, 1, 1]}), planar).1, "axis");
    // Past a wall.
    let walls = json!({"walls": [{"half_space": {"normal": [1, 0, 0], "offset": 0}}]});
    assert!(fault(json!({}), walls).2.contains("past wall 0"));
}
