//! Forces on walls: weights, springs between plates, grooves, friction, and the torque about a wall's point.

use super::*;
use crate::measure::walls::OnWalls;
use crate::scene::Scene;
use crate::simulation::Simulation;
use serde_json::{Value, json};

/// A measured state: values by column, and one row per surface.
struct Borne {
    found: Found,
}

impl Borne {
    fn all(&self, column: &str) -> Cell {
        value(&self.found, "walls", column)
    }

    /// A value of a surface.
    fn on(&self, surface: usize, column: &str) -> Cell {
        let columns = OnWalls.profile().unwrap().columns;
        self.found.rows[surface][columns.iter().position(|c| c.name == column).unwrap()]
    }
}

/// What the walls of a scene bear at its end.
fn at_the_end(scene: &Value) -> Borne {
    let scene = Scene::parse(&scene.to_string(), "test").unwrap();
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let state = simulation.state().unwrap().clone();
    let (step, time) = (state.step, simulation.time());
    let state =
        Snapshot { step, time, bodies: state.bodies, warm: Some(state.warm), removed: Vec::new(), fields: Vec::new() };
    let frame = Frame::of_scene(&scene, "a test".into());
    let found = OnWalls.of(&View::new(&state, &frame, &Settings::default())).unwrap();
    Borne { found }
}

/// Solves are this tight, so that forces are right to about this part.
const TIGHT: f64 = 1e-9;

fn scene(rest: Value) -> Value {
    let mut scene = json!({"name": "borne", "time": {"dt": 0.01, "end": 3}, "solver": {"tolerance": TIGHT}});
    scene.as_object_mut().unwrap().extend(rest.as_object().unwrap().clone());
    scene
}

fn ball(position: [f64; 3]) -> Value {
    json!({"shape": {"sphere": {"radius": 0.5}}, "position": position})
}

fn floor() -> Value {
    json!({"half_space": {"normal": [0, 0, 1], "offset": 0}})
}

#[test]
fn a_floor_bears_the_weight_of_what_rests_on_it() {
    let lying = [0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt(), 0.0];
    let rod = json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "position": [3, 0, 0.25], "orientation": lying});
    let ring = json!({"shape": {"torus": {"major_radius": 1, "minor_radius": 0.25}}, "position": [0, 3, 0.25]});
    let egg = json!({"shape": {"ellipsoid": {"radii": [0.8, 0.6, 0.4]}}, "position": [3, 3, 0.4]});
    // The lower ball, both ends of the rod, and three places of the ring or one of the egg.
    for (last, places) in [(ring, 6.0), (egg, 4.0)] {
        let all = [ball([0.0, 0.0, 0.5]), ball([0.0, 0.0, 1.5]), rod.clone(), last];
        for law in [json!({"overdamped": {"drag": 1}}), json!({"inertial": {"density": 1}})] {
            let borne = at_the_end(&scene(json!({"dynamics": law, "bodies": all, "walls": [floor()],
                "periodic": {"lengths": [8, 10, null]}, "forces": [{"uniform": {"force": [0, 0, -0.25]}}]})));
            for (column, expected) in [("wall_force", 1.0), ("wall_force_z", -1.0), ("wall_pressure", 1.0 / 80.0)] {
                assert_near(borne.all(column), expected, 1e-4);
            }
            assert_eq!(borne.all("wall_contacts"), Some(places), "{law}");
            assert_near(borne.all("wall_force_most"), 0.5, 1e-4);
            assert_near(borne.all("wall_force_x"), 0.0, 1e-6);
            assert_eq!((borne.on(0, "torque_x"), borne.on(0, "area")), (None, Some(80.0)));
            assert!(borne.found.remark.is_some_and(|remark| remark.contains("periodic")));
        }
    }
}

#[test]
fn plates_bear_what_a_spring_between_them_does() {
    // The gap leaves the centres 2 apart, and the spring would have them 2.5 apart.
    let borne = at_the_end(&scene(json!({
        "walls": [{"channel": {"normal": [0, 0, 1], "center": [0, 0, 1.5], "width": 3}}],
        "bodies": [ball([1.0, 0.0, 0.5]), ball([1.0, 0.0, 2.5])],
        "bonds": [{"bodies": [0, 1], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": 4, "length": 2.5}]})));
    for (surface, sign) in [(0, -1.0), (1, 1.0)] {
        assert_near(borne.on(surface, "normal_force"), 2.0, 1e-4);
        assert_near(borne.on(surface, "force_z"), sign * 2.0, 1e-4);
        assert_eq!(borne.on(surface, "face"), Some(surface as f64));
        assert_eq!(borne.on(surface, "pressure"), None, "a plane without end has no area");
    }
    assert_near(borne.all("wall_force_z"), 0.0, 1e-5);
    assert_near(borne.all("wall_force"), 4.0, 1e-4);
}

#[test]
fn a_groove_bears_a_ball_by_the_cosine_of_its_slope() {
    let side = |x: i32| json!({"half_space": {"normal": [x, 0, 1], "offset": 0}});
    let borne = at_the_end(&scene(json!({"walls": [side(1), side(-1)],
        "bodies": [ball([0.0, 0.0, 0.5 * 2.0_f64.sqrt()])], "forces": [{"uniform": {"force": [0, 0, -3]}}]})));
    for (surface, sign) in [(0, -1.0), (1, 1.0)] {
        assert_near(borne.on(surface, "normal_force"), 3.0 / 2.0_f64.sqrt(), 1e-4);
        assert_near(borne.on(surface, "force_x"), sign * 1.5, 1e-4);
        assert_near(borne.on(surface, "force_z"), -1.5, 1e-4);
    }
}

#[test]
fn walls_bear_all_that_bodies_in_them_do_not_bear_themselves() {
    // Action and reaction: forces between bodies cancel, so that walls bear the loads of all bodies at rest.
    let balls: Vec<Value> = (0..12).map(|k| ball([0.6 + f64::from(k % 3), 0.6 + f64::from(k / 3), 0.0])).collect();
    let load = [0.3, -1.0];
    let borne = at_the_end(&scene(json!({"planar": true, "time": {"dt": 0.01, "end": 20}, "bodies": balls,
        "walls": [{"box": {"minimum": [0, 0, -1], "maximum": [3.4, 5, 1]}}],
        "forces": [{"uniform": {"force": [load[0], load[1], 0]}}]})));
    assert_near(borne.all("wall_force_x"), 12.0 * load[0], 2e-3);
    assert_near(borne.all("wall_force_y"), 12.0 * load[1], 2e-3);
    assert_eq!(borne.all("wall_force_z"), None);
    let faces: Vec<f64> = (0..4).map(|surface| borne.on(surface, "normal_force").unwrap()).collect();
    assert_near(Some(faces[1] - faces[0]), 12.0 * load[0], 2e-3);
    assert_near(Some(faces[2] - faces[3]), -12.0 * load[1], 2e-3);
    let all: f64 = faces.iter().sum();
    assert_near(borne.all("wall_pressure"), all / (2.0 * (3.4 + 5.0)), 1e-12);
    assert_near(borne.on(2, "pressure"), faces[2] / 3.4, 1e-12);
}

#[test]
fn a_torque_is_about_the_point_that_the_wall_turns_about() {
    let one = |motion: Value| {
        let mut wall = floor();
        if !motion.is_null() {
            wall["half_space"]["motion"] = motion;
        }
        at_the_end(&scene(json!({"walls": [wall], "bodies": [ball([3.0, -2.0, 0.5])],
            "forces": [{"uniform": {"force": [0, 0, -0.5]}}]})))
    };
    // (3, -2, 0) x (0, 0, -0.5); the moving floor's point has gone 3 along x.
    for (motion, along) in [(Value::Null, 3.0), (json!({"velocity": [1, 0, 0]}), 0.0)] {
        let borne = one(motion);
        assert_near(borne.on(0, "torque_x"), 1.0, 1e-4);
        assert_near(borne.on(0, "torque_y"), 0.5 * along, 1e-4);
        assert_near(borne.on(0, "torque_z"), 0.0, 1e-6);
    }
}

#[test]
fn friction_is_part_of_the_force() {
    let rod = json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "position": [0, 0, 0.25],
        "orientation": [0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt(), 0.0]});
    let borne = at_the_end(&scene(json!({"walls": [floor()], "bodies": [rod],
        "contact": {"friction": {"bodies": 0.5, "walls": 0.5}},
        "forces": [{"uniform": {"force": [0.2, 0, -1]}}]})));
    assert_near(borne.all("wall_force_z"), -1.0, 1e-3);
    assert_near(borne.all("wall_force_x"), 0.2, 1e-3);
    assert_near(borne.all("wall_force"), 1.0, 1e-3);
}

#[test]
fn what_has_no_wall_forces_says_why() {
    let open = state(bodies([(BALL, DVec3::ZERO, DQuat::IDENTITY)]), Some(&[]));
    let LeftOut(reason) = of_settings("walls", &open, false, &Settings::default()).unwrap_err();
    assert!(reason.contains("no walls"), "{reason}");
    let mut frame = frame(false);
    frame.walls =
        Scene::parse(&scene(json!({"walls": [floor()], "bodies": [ball([0.0, 0.0, 0.5])]})).to_string(), "test")
            .unwrap()
            .walls;
    frame.sub_spheres = true;
    let settings = Settings::default();
    let LeftOut(reason) = OnWalls.of(&View::new(&open, &frame, &settings)).unwrap_err();
    assert!(reason.contains("sub-spheres"), "{reason}");
}
