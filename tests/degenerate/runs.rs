//! Runs that were wrong where a direction was made of rounding, or where the plane was not.

use glam::{DQuat, DVec3};
use relcp::Scene;
use relcp::simulation::Simulation;
use relcp::step::{contacts, max_overlap};
use std::f64::consts::FRAC_PI_2;

/// The simulation at its end.
fn ended(text: &str) -> Simulation {
    let mut simulation = Simulation::new(Scene::parse(text, "test").unwrap()).unwrap();
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
    }
    simulation
}

/// A ball that is drawn into a tilted ring along its axis rests where it touches all round: `h^2 + 1 = 1.2^2`. It came
/// to rest 0.200 away, 0.180 deep.
#[test]
fn a_ball_on_the_axis_of_a_tilted_ring_rests_on_it() {
    let simulation = ended(
        r#"{"name": "ball in ring", "time": {"dt": 0.02, "end": 3}, "bodies": [
            {"shape": {"torus": {"major_radius": 1, "minor_radius": 0.5}}, "position": [0, 0, 0], "axis": [1, 1, 0]},
            {"shape": {"sphere": {"radius": 0.7}}, "position": [-1.0606601717798212, -1.0606601717798212, 0]}],
            "forces": [{"trap": {"stiffness": 1, "center": [0, 0, 0]}}]}"#,
    );
    let at = &simulation.state().unwrap().bodies.position;
    assert!((at[0].distance(at[1]) - 0.44_f64.sqrt()).abs() < 1e-3, "{}", at[0].distance(at[1]));
}

/// A ring that is pushed sideways in a tilted tube that it is coaxial with stops where it touches the tube, 2.2 from
/// the axis. It went on into the wall.
#[test]
fn a_ring_coaxial_with_a_tilted_tube_stops_at_its_wall() {
    let simulation = ended(
        r#"{"name": "ring in tube", "time": {"dt": 0.05, "end": 5},
            "walls": [{"cylinder": {"center": [0, 0, 0], "axis": [1, 2, 3], "radius": 4}}],
            "bodies": [{"shape": {"torus": {"major_radius": 1.5, "minor_radius": 0.3}},
                "position": [2.672612, 5.345225, 8.017837], "axis": [1, 2, 3]}],
            "forces": [{"uniform": {"force": [2.683282, -1.341641, 0]}}]}"#,
    );
    let axis = DVec3::new(1.0, 2.0, 3.0).normalize();
    let body = simulation.state().unwrap().bodies.placed(0);
    let around = |k: i32| {
        let turn = DQuat::from_rotation_z(f64::from(k) * 0.001 * std::f64::consts::TAU);
        (body.position + body.orientation * (turn * DVec3::X * 1.5)).cross(axis).length() + 0.3
    };
    let farthest = (0..1000).map(around).fold(0.0, f64::max);
    assert!((farthest - 4.0).abs() < 1e-4, "{farthest}");
    assert!((body.position.cross(axis).length() - 2.2).abs() < 1e-3, "{body:?}");
}

/// What flies along the axis of a tilted tube that it hardly fits into keeps its speed. It was stopped.
#[test]
fn a_body_on_the_axis_of_a_snug_tilted_tube_keeps_its_speed() {
    let shapes = [r#"{"sphere": {"radius": 1}}"#, r#"{"spherocylinder": {"diameter": 2, "length": 5}}"#];
    for (shape, dt) in shapes.into_iter().flat_map(|shape| [0.2, 0.01].map(|dt| (shape, dt))) {
        let simulation = ended(&format!(
            r#"{{"name": "in a tube", "dynamics": {{"inertial": {{"density": 1}}}}, "time": {{"dt": {dt}, "end": 2}},
            "walls": [{{"cylinder": {{"center": [0, 0, 0], "axis": [4, -2, 1], "radius": 1.005}}}}],
            "bodies": [{{"shape": {shape}, "axis": [4, -2, 1],
                "position": [0.4364357804719848, -0.2182178902359924, 0.1091089451179962],
                "velocity": [0.8728715609439696, -0.4364357804719848, 0.2182178902359924]}}]}}"#
        ));
        let speed = simulation.state().unwrap().bodies.velocity[0].length();
        assert!((speed - 1.0).abs() < 1e-9, "{shape} at dt {dt}: {speed}");
    }
}

/// Flat ellipsoids that lie in the plane overlap by as much as they must be pushed apart in it. The overlap across it
/// was told, 0.0017, with a normal that no body can be pushed along.
#[test]
fn bodies_of_the_plane_overlap_by_what_parts_them_in_the_plane() {
    let flat = DQuat::from_rotation_y(FRAC_PI_2);
    let [x, y, z, w] = flat.to_array();
    let body = |at: f64| {
        let shape = r#"{"ellipsoid": {"radii": [0.001, 1, 1]}}"#;
        format!(r#"{{"shape": {shape}, "position": [{at}, 0, 0], "orientation": [{w}, {x}, {y}, {z}]}}"#)
    };
    let bodies = [0.0, 1.0].map(body).join(", ");
    let text = format!(r#"{{"name": "flat", "planar": true, "time": {{"dt": 0.1, "end": 1}}, "bodies": [{bodies}]}}"#);
    let scene = Scene::parse(&text, "test").unwrap();
    let bodies = scene.build().unwrap();
    let found = contacts(&bodies, 0.0);
    assert!((found[0].separation + 1.0).abs() < 1e-9 && found[0].normal.z.abs() < 1e-9, "{:?}", found[0]);
    assert!((max_overlap(&bodies, &scene.walls()) - 1.0).abs() < 1e-9);
    // A state says of itself that it is of the plane.
    let state = relcp::step::State { bodies, ..Default::default() };
    let read = relcp::record::decode(&relcp::record::encode(&state, "", 0.0, None).unwrap()).unwrap().1;
    assert_eq!(contacts(&read.bodies, 0.0), found);
}
