//! Bodies bonded end to end.

use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::{Chain, FaultKind, Generate, Scene, SceneError, Time};
use relcp::separation::separation;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use serde_json::{Value, json};

fn scene(rule: Value, more: Value) -> Result<Scene, SceneError> {
    let mut scene =
        json!({"name": "placed", "seed": 3, "time": {"dt": 0.001, "end": 0.05}, "generate": [{"chain": rule}]});
    scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    Scene::parse(&scene.to_string(), "placed")
}

fn rods(count: u64, path: Value) -> Value {
    json!({"count": count, "shape": {"spherocylinder": {"diameter": 0.25, "length": 1}}, "stiffness": 100, "gap": 0.05, "path": path})
}

/// The ends of a body's z axis.
fn tips(bodies: &Bodies, i: usize) -> [DVec3; 2] {
    let half = 0.5 * bodies.shape[i].major_axis() * (bodies.orientation[i] * DVec3::Z);
    [bodies.position[i] - half, bodies.position[i] + half]
}

fn overlap_free(bodies: &Bodies) {
    super::far_apart(bodies, |a, b| {
        let [a, b] = bodies.pair(a, b);
        separation(&a, &b, None).unwrap().separation > -1e-12
    });
}

/// All bonds at their rest length; how many there are.
fn at_rest(of: &Scene, bodies: &Bodies) -> usize {
    let bonds = of.all_bonds();
    for bond in &bonds {
        let [a, b] = [0, 1].map(|end| {
            let i = bond.bodies[end];
            bodies.position[i] + bodies.orientation[i] * DVec3::from(bond.at[end])
        });
        assert!((a.distance(b) - bond.length).abs() < 1e-12, "{:?}: {}", bond.bodies, a.distance(b));
    }
    bonds.len()
}

#[test]
fn a_straight_chain_a_ring_and_a_bent_chain_start_at_rest() {
    let straight = scene(rods(24, json!({"straight": {"center": [1, 2, 3], "axis": [0, 2, 0]}})), json!({})).unwrap();
    let bodies = straight.build().unwrap();
    assert_eq!((bodies.len(), at_rest(&straight, &bodies)), (24, 23));
    let middle = 0.5 * (bodies.position[0] + bodies.position[23]);
    assert!((middle - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-12);
    assert!((tips(&bodies, 23)[1].y - tips(&bodies, 0)[0].y - (24.0 + 23.0 * 0.05)).abs() < 1e-12);
    for count in [3, 5, 40] {
        let mut rule = rods(count, json!({"ring": {}}));
        rule["gap"] = json!(0.2);
        let ring = scene(rule, json!({"planar": true, "time": {"dt": 0.0005, "end": 0.05}})).unwrap();
        let bodies = ring.build().unwrap();
        assert_eq!(at_rest(&ring, &bodies) as u64, count);
        overlap_free(&bodies);
        assert!(bodies.position.iter().sum::<DVec3>().length() < 1e-9);
    }
    // Every tip is on the line, whose corners are of 53 degrees.
    let points = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [9.0, 4.0, 0.0], [12.24, 8.32, 7.2]];
    let bent = scene(rods(18, json!({"along": {"points": points}})), json!({})).unwrap();
    let bodies = bent.build().unwrap();
    assert_eq!(at_rest(&bent, &bodies), 17);
    overlap_free(&bodies);
    for tip in (0..18).flat_map(|i| tips(&bodies, i)) {
        let from = |pair: &[[f64; 3]]| {
            let [a, b] = [DVec3::from(pair[0]), DVec3::from(pair[1])];
            let part = ((tip - a).dot(b - a) / a.distance_squared(b)).clamp(0.0, 1.0);
            tip.distance(a + part * (b - a))
        };
        let off = points.windows(2).map(from).fold(f64::INFINITY, f64::min);
        assert!(off < 1e-9, "{tip} {off}");
    }
    assert!(tips(&bodies, 0)[0].length() < 1e-12);
}

#[test]
fn balls_are_bonded_at_their_centres() {
    let rule = json!({"count": 10, "shape": {"sphere": {"radius": 0.5}}, "stiffness": 10});
    let of = scene(rule, json!({"planar": true})).unwrap();
    let bodies = of.build().unwrap();
    assert_eq!(at_rest(&of, &bodies), 9);
    for (i, x) in bodies.position.iter().enumerate() {
        // A fifth of a diameter is between them.
        assert!((*x - 1.2 * (i as f64 - 4.5) * DVec3::X).length() < 1e-12, "{x}");
    }
    assert!(of.all_bonds().iter().all(|bond| bond.at == [[0.0; 3], [0.0, 0.0, -0.0]]));
}

#[test]
fn a_random_walk_avoids_itself_and_bends_no_more_than_it_may() {
    for (planar, count, bend) in [(false, 300, 60.0), (true, 200, 60.0), (true, 60, 15.0), (false, 100, 10.0)] {
        let path = json!({"random_walk": {"start": [2, 1, 0], "largest_bend": bend}});
        let of = scene(rods(count, path), json!({"planar": planar})).unwrap();
        let bodies = of.build().unwrap();
        assert_eq!(at_rest(&of, &bodies) as u64, count - 1);
        overlap_free(&bodies);
        assert!((tips(&bodies, 0)[0] - DVec3::new(2.0, 1.0, 0.0)).length() < 1e-12);
        let axes: Vec<DVec3> = bodies.orientation.iter().map(|q| *q * DVec3::Z).collect();
        let bends: Vec<f64> = axes.windows(2).map(|pair| pair[0].angle_between(pair[1]).to_degrees()).collect();
        let largest = bends.iter().copied().fold(0.0, f64::max);
        assert!(largest <= bend + 1e-9 && largest > 0.9 * bend, "{largest}");
        if planar {
            assert!(bodies.position.iter().all(|x| x.z == 0.0));
        }
        assert_eq!(of.build().unwrap(), bodies);
    }
}

/// Bends of 10 degrees avoid nothing: their cosine is uniform from cos 10 to 1.
#[test]
fn directions_of_a_walk_are_uniform_within_its_bend() {
    let of = scene(rods(100, json!({"random_walk": {"largest_bend": 10}})), json!({})).unwrap();
    let bodies = of.build().unwrap();
    let axes: Vec<DVec3> = bodies.orientation.iter().map(|q| *q * DVec3::Z).collect();
    let (least, count) = (10.0_f64.to_radians().cos(), 99.0);
    let mean = axes.windows(2).map(|pair| pair[0].dot(pair[1])).sum::<f64>() / count;
    let error = (1.0 - least) / (12.0_f64 * count).sqrt();
    assert!((mean - 0.5 * (1.0 + least)).abs() < 4.0 * error, "{mean} {least}");
}

#[test]
fn walks_keep_inside_of_walls_and_clear_of_earlier_bodies() {
    let post = json!({"bodies": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0], "fixed": true}],
        "walls": [{"sphere": {"center": [0, 0, 0], "radius": 4}}]});
    let mut rule = rods(40, json!({"random_walk": {"start": [2.5, 0, 0]}}));
    rule["repeat"] = json!([{"count": 2, "offset": [-5, 0, 0]}]);
    let of = scene(rule, post).unwrap();
    let bodies = of.build().unwrap();
    assert_eq!((bodies.len(), at_rest(&of, &bodies)), (81, 78));
    overlap_free(&bodies);
    for i in 1..81 {
        let half = 0.375 * (bodies.orientation[i] * DVec3::Z);
        assert!([half, -half].iter().all(|half| (bodies.position[i] + *half).length() <= 3.875 + 1e-12));
    }
    // The walk has no room; the error gives the number of bodies that it placed.
    let tight = json!({"walls": [{"sphere": {"center": [0, 0, 0], "radius": 0.9}}]});
    let error = scene(rods(40, json!({"random_walk": {}})), tight).unwrap().build().unwrap_err();
    assert_eq!((error.kind(), error.key()), (FaultKind::Placement, "generate.0.chain.path.random_walk"));
    assert!(error.message().contains("of 40 bodies were placed"), "{}", error.message());
}

/// The chain of a rule runs as its bodies and bonds one by one, to the bit.
#[test]
fn a_chain_runs_as_its_bodies_and_bonds_do_when_listed() {
    let mut rule = rods(12, json!({"random_walk": {"largest_bend": 30}}));
    rule["repeat"] = json!([{"count": 2, "offset": [0, 0, 3]}]);
    let more = json!({"thermal": {"temperature": 0.01}, "time": {"dt": 0.001, "end": 0.1},
        "flow": {"shear": {"rate": 0.5, "direction": [1, 0, 0], "gradient": [0, 1, 0]}}});
    let of = scene(rule, more).unwrap();
    let listed = of.final_scene(&of.build().unwrap(), 0.0);
    assert_eq!((listed.bonds.len(), listed.bodies.len(), listed.generate.len()), (22, 24, 0));
    let run = |scene: Scene| {
        let mut simulation = Simulation::new(scene).unwrap();
        while !simulation.done() {
            assert!(simulation.step().unwrap().max_overlap <= 1e-5);
        }
        simulation.state().unwrap().bodies.clone()
    };
    let (ruled, one_by_one) = (run(of), run(listed));
    assert_eq!(ruled.position, one_by_one.position);
    assert_eq!(ruled.orientation, one_by_one.orientation);
    let stretched = ruled.position[0].distance(ruled.position[1]);
    assert!((stretched - 1.05).abs() < 0.2, "{stretched}");
}

#[test]
fn a_chain_that_makes_no_sense_is_refused_with_its_key() {
    let fault = |more: Value, keys: Value| {
        let mut rule = rods(8, json!({"straight": {"axis": [1, 0, 0]}}));
        rule.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let error = scene(rule, keys).and_then(|of| of.build()).unwrap_err();
        let key = error.key().strip_prefix("generate.0.chain").unwrap_or("elsewhere").to_owned();
        (key, error.message().to_owned())
    };
    let ring = json!({"torus": {"major_radius": 1, "minor_radius": 0.1}});
    for (more, key, says) in [
        (json!({"count": 1}), ".count", "at least 2"),
        (json!({"count": 2, "path": {"ring": {}}}), ".count", "at least 3"),
        (json!({"shape": ring}), ".shape.torus", "no ends"),
        (json!({"stiffness": 0}), ".stiffness", "positive"),
        (json!({"gap": -0.1}), ".gap", "negative"),
        (json!({"gap": 0, "path": {"ring": {}}}), ".gap", "overlap each other"),
        (json!({"break_force": -1}), ".break_force", "positive"),
        (json!({"path": {"straight": {"axis": [0, 0, 0]}}}), ".path.straight.axis", "direction"),
        (json!({"path": {"along": {"points": [[0, 0, 0]]}}}), ".path.along.points", "two points"),
        (json!({"path": {"along": {"points": [[0, 0, 0], [5, 0, 0]]}}}), ".path.along.points", "holds 4 of 8 bodies"),
        (json!({"path": {"random_walk": {"largest_bend": 181}}}), ".path.random_walk.largest_bend", "at most 180"),
        (json!({"path": {"spiral": {}}}), ".path.spiral", "unknown key `spiral`"),
    ] {
        let (place, words) = fault(more.clone(), json!({}));
        assert!(place == key && words.contains(says), "{more}: {place}: {words}");
    }
    let midpoint = json!({"time": {"dt": 0.01, "end": 1, "stepping": "midpoint"}});
    let (key, words) = fault(json!({"stiffness": 1e5}), midpoint);
    assert!(key == ".stiffness" && words.contains("too stiff for time.dt"), "{key} {words}");
    let (key, words) = fault(json!({}), json!({"growth": {"rate": 1, "division_length": 4}}));
    assert!(key.is_empty() && words.contains("growth.group"), "{key} {words}");
    let fixed = json!({"groups": {"held": {"fixed": true}}});
    assert_eq!(fault(json!({"group": "held"}), fixed).0, ".group");
    let planar = fault(json!({"path": {"straight": {"axis": [1, 0, 1]}}}), json!({"planar": true}));
    assert_eq!(planar.0, ".path.straight.axis.2");
    let periodic = json!({"periodic": {"lengths": [null, 30, null]}});
    let long = fault(json!({"gap": 16}), periodic);
    assert!(long.0 == ".gap" && long.1.contains("half of the shortest period"), "{long:?}");
}

#[test]
fn a_rigid_chain_keeps_its_length_where_it_is_pulled() {
    let mut rule = rods(6, json!({"straight": {"axis": [1, 0, 0]}}));
    rule["stiffness"] = json!("rigid");
    let pull = json!({"time": {"dt": 0.05, "end": 1}, "forces": [{"radial_outward": {}}]});
    let of = scene(rule, pull).unwrap();
    assert!(of.all_bonds().iter().all(relcp::scene::Bond::is_rigid));
    let mut simulation = Simulation::new(of).unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let bodies = &simulation.state().unwrap().bodies;
    for pair in bodies.position.windows(2) {
        assert!((pair[0].distance(pair[1]) - 1.05).abs() < 1e-5, "{pair:?}");
    }
}

#[test]
fn chains_in_code_are_those_of_files() {
    let mut of = Scene::new("code", Time::new(0.001, 1.0));
    let rod = Shape::Spherocylinder { diameter: 0.25, length: 1.0 };
    of.generate = vec![Generate::Chain(Chain::new(6, rod, 100.0))];
    let bodies = of.build().unwrap();
    assert_eq!((bodies.len(), at_rest(&of, &bodies)), (6, 5));
    assert_eq!(Scene::parse(&of.to_json(), "file").unwrap().build().unwrap(), bodies);
}
