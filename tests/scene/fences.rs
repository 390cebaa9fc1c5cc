//! Fixed rods along a line, and copies of what rules place.

use glam::DVec3;
use relcp::scene::{FaultKind, Fence, Generate, Repeat, Scene, SceneError, Time};
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use serde_json::{Value, json};

fn scene(rules: Value, more: Value) -> Result<Scene, SceneError> {
    let mut scene =
        json!({"name": "placed", "seed": 3, "time": {"dt": 0.01, "end": 0.5}, "planar": true, "generate": rules});
    scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    Scene::parse(&scene.to_string(), "placed")
}

const TRENCH: [[f64; 3]; 6] =
    [[-2.0, 0.0, 0.0], [-0.8, 0.0, 0.0], [-0.8, -5.0, 0.0], [0.8, -5.0, 0.0], [0.8, 0.0, 0.0], [2.0, 0.0, 0.0]];

#[test]
fn rods_of_a_fence_share_their_ends_and_its_copies_stand_beside_it() {
    let repeat = json!([{"count": 3, "offset": [4, 0, 0]}, {"count": 2, "offset": [0, 9, 0]}]);
    let rule = json!({"fence": {"points": TRENCH, "diameter": 0.4, "repeat": repeat, "group": "device"}});
    let of = scene(json!([rule]), json!({})).unwrap();
    let bodies = of.build().unwrap();
    assert_eq!((bodies.len(), of.body_count()), (5 * 6, 30));
    for (i, (position, q)) in bodies.position.iter().zip(&bodies.orientation).enumerate() {
        let (segment, copy) = (i / 6, i % 6);
        let offset = DVec3::new(4.0 * (copy % 3) as f64, 9.0 * (copy / 3) as f64, 0.0);
        let Shape::Spherocylinder { diameter, length } = bodies.shape[i] else { panic!("{:?}", bodies.shape[i]) };
        let half = 0.5 * (length - diameter) * (*q * DVec3::Z);
        for (end, point) in [(*position - half, TRENCH[segment]), (*position + half, TRENCH[segment + 1])] {
            assert!((end - DVec3::from(point) - offset).length() < 1e-12, "{i}: {end}");
        }
        assert_eq!((diameter, bodies.group[i]), (0.4, 0));
    }
    // They are fixed, also in what a run writes.
    let last = of.final_scene(&bodies, 0.25);
    assert!(last.bodies.iter().all(|body| body.fixed) && last.generate.is_empty());
    assert_eq!(Scene::parse(&last.to_json(), "final").unwrap().build().unwrap(), bodies);
    // The same in code.
    let mut code = Scene::new("code", Time::new(0.01, 0.5));
    let mut fence = Fence::new(TRENCH.to_vec(), 0.4);
    fence.repeat = vec![Repeat::new(3, [4.0, 0.0, 0.0]), Repeat::new(2, [0.0, 9.0, 0.0])];
    code.generate = vec![Generate::Fence(fence)];
    assert_eq!(code.build().unwrap().position, bodies.position);
}

#[test]
fn a_closed_fence_holds_what_is_pushed_against_it_and_posts_stand_alone() {
    let square = json!([[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]);
    let rules = json!([
        {"fence": {"points": square, "diameter": 0.5, "closed": true}},
        {"fence": {"points": [[0, 0, 0]], "diameter": 1, "repeat": [{"count": 2, "offset": [1.5, 0, 0]}]}},
        {"founder": {"diameter": 0.5, "length": 2, "position": [-1, 2, 0], "group": "cells"}},
    ]);
    let forces = json!([{"uniform": {"force": [9, -7, 0]}}]);
    let of = scene(rules, json!({"forces": forces, "time": {"dt": 0.02, "end": 6}})).unwrap();
    let start = of.build().unwrap();
    assert_eq!(start.len(), 7);
    assert!(matches!(start.shape[4], Shape::Sphere { radius } if radius == 0.5));
    let mut simulation = Simulation::new(of).unwrap();
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= 1e-5, "{}", report.max_overlap);
    }
    let bodies = &simulation.state().unwrap().bodies;
    for i in 0..6 {
        assert_eq!((bodies.position[i], bodies.orientation[i]), (start.position[i], start.orientation[i]));
    }
    // The cell comes to rest in the corner: inside by half of both thicknesses.
    let half = 0.75 * (bodies.orientation[6] * DVec3::Z);
    for cap in [bodies.position[6] - half, bodies.position[6] + half] {
        assert!(cap.x <= 2.5 + 1e-5 && cap.y >= -2.5 - 1e-5, "{cap}");
    }
    let [x, y] = [bodies.position[6].x + half.x.abs(), bodies.position[6].y - half.y.abs()];
    assert!((x - 2.5).abs() < 1e-3 && (y + 2.5).abs() < 1e-3, "{x} {y}");
}

#[test]
fn founders_are_copied_beside_a_fence() {
    let repeat = json!([{"count": 3, "offset": [4, 0, 0]}]);
    let founder = json!({"founder": {"diameter": 1, "length": 2, "position": [0, -3, 0], "angle": 90, "count": 2, "repeat": repeat}});
    let bodies = scene(json!([founder]), json!({})).unwrap().build().unwrap();
    let places: Vec<[f64; 2]> = bodies.position.iter().map(|x| [x.x, x.y]).collect();
    let expected = [[0.6, -3.0], [-0.6, -3.0], [4.6, -3.0], [3.4, -3.0], [8.6, -3.0], [7.4, -3.0]];
    for (place, right) in places.iter().zip(expected) {
        assert!((place[0] - right[0]).abs() < 1e-12 && (place[1] - right[1]).abs() < 1e-12, "{places:?}");
    }
}

/// A fence may reach past a wall, as fixed bodies may.
#[test]
fn a_fence_stands_in_walls_and_its_overlap_does_not_count() {
    let walls = json!({"walls": [{"box": {"minimum": [-2, -4, -1], "maximum": [2, 4, 1]}}]});
    let rules = json!([{"fence": {"points": TRENCH, "diameter": 0.4}}, {"founder": {"diameter": 1, "length": 2, "position": [0, -2, 0], "angle": 90}}]);
    let mut simulation = Simulation::new(scene(rules, walls).unwrap()).unwrap();
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
    }
}

#[test]
fn a_fence_that_makes_no_sense_is_refused_with_its_key() {
    let fault = |more: Value, keys: Value| {
        let mut rule = json!({"points": TRENCH, "diameter": 0.4});
        rule.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let error = scene(json!([{"fence": rule}]), keys).unwrap_err();
        let key = error.key().strip_prefix("generate.0.fence").unwrap_or("elsewhere").to_owned();
        (error.kind(), key, error.message().to_owned())
    };
    for (more, kind, key, says) in [
        (json!({"points": []}), FaultKind::BadValue, ".points", "a point at least"),
        (json!({"points": [[0, 0, 0], [0, 0, 0]]}), FaultKind::BadValue, ".points.1", "the point before it again"),
        (json!({"points": [[0, 0, 0], [0, 0, 1]]}), FaultKind::BadValue, ".points.1.2", "must be 0 in a planar scene"),
        (json!({"points": [[0, 0, 0], [1, 0]]}), FaultKind::WrongType, ".points.1", "length 3"),
        (json!({"points": [[0, 0, 0], [1, 0, 0]], "closed": true}), FaultKind::BadValue, ".closed", "three points"),
        (
            json!({"points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0]], "closed": true}),
            FaultKind::BadValue,
            ".points.3",
            "omit it",
        ),
        (json!({"diameter": 0}), FaultKind::BadValue, ".diameter", "positive"),
        (json!({"repeat": [{"count": 0, "offset": [1, 0, 0]}]}), FaultKind::BadValue, ".repeat.0.count", "at least 1"),
        (
            json!({"repeat": [{"count": 2, "offset": [0, 0, 0]}]}),
            FaultKind::BadValue,
            ".repeat.0.offset",
            "in one place",
        ),
        (json!({"repeat": [{"count": 2, "offset": [1, 0, 1]}]}), FaultKind::BadValue, ".repeat.0.offset.2", "planar"),
        (json!({"repeat": [{"count": 99999999, "offset": [1, 0, 0]}]}), FaultKind::TooLarge, ".repeat", "copies"),
        (json!({"repeat": {"count": 2, "offset": [1, 0, 0]}}), FaultKind::WrongType, ".repeat", "a list"),
        (json!({"point": [[0, 0, 0]]}), FaultKind::UnknownKey, ".point", "nearest is `points`"),
    ] {
        let (found, place, words) = fault(more.clone(), json!({}));
        assert!(found == kind && place == key && words.contains(says), "{more}: {found:?} {place}: {words}");
    }
    let (_, key, words) = fault(json!({}), json!({"growth": {"rate": 1, "division_length": 4}}));
    assert!(key.is_empty() && words.contains("growth.group"), "{key} {words}");
}
