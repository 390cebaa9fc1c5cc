//! The three ways to say how a body is oriented.

use crate::scenes::{parse, refusal};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::scene::Scene;
use serde_json::{Value, json};
use std::f64::consts::TAU;

fn scene(planar: bool, keys: &Value) -> Value {
    let mut body = json!({"shape": {"ellipsoid": {"radii": [0.3, 0.5, 1]}}, "position": [0, 0, 0]});
    body.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
    json!({"name": "one", "planar": planar, "time": {"dt": 0.1, "end": 1}, "bodies": [body]})
}

fn built(planar: bool, keys: &Value) -> (Scene, Bodies) {
    let scene = parse(&scene(planar, keys));
    let bodies = scene.build().unwrap();
    (scene, bodies)
}

#[test]
fn an_axis_is_where_the_bodys_z_points_and_its_y_stays_level() {
    let axes =
        [[1.0, 0.0, 0.0], [-3.0, 4.0, 0.0], [1e-3, -2e-3, 5e-3], [0.0, 0.0, 7.0], [0.0, 0.0, -1e30], [2.0, 1.0, -2.0]];
    for axis in axes {
        let (_, bodies) = built(false, &json!({"axis": axis}));
        let (z, y) = (bodies.orientation[0] * DVec3::Z, bodies.orientation[0] * DVec3::Y);
        assert!((z - DVec3::from(axis).normalize()).length() < 1e-15, "{axis:?}: {z}");
        assert!(y.z.abs() < 1e-15, "{axis:?}: {y}");
    }
}

/// An ellipsoid of three axes stays mirrored by the plane at every angle.
#[test]
fn an_angle_turns_the_axis_in_the_plane() {
    for degrees in (-36..=36).map(|k| 10.0 * f64::from(k)) {
        let (_, bodies) = built(true, &json!({"angle": degrees}));
        let z = bodies.orientation[0] * DVec3::Z;
        let expected = DVec3::new((degrees / 360.0 * TAU).cos(), (degrees / 360.0 * TAU).sin(), 0.0);
        assert!((z - expected).length() < 1e-14, "{degrees}: {z}");
        let (_, same) = built(true, &json!({"axis": expected.with_z(0.0).to_array()}));
        assert!(same.orientation[0].dot(bodies.orientation[0]).abs() > 1.0 - 1e-14);
    }
}

#[test]
fn what_is_written_is_read_back_to_the_same_bits_and_ends_as_an_orientation() {
    for keys in [json!({"axis": [1, 2, 0]}), json!({"angle": 33}), json!({}), json!({"orientation": [1, 0, 0, 0]})] {
        let (scene, bodies) = built(true, &keys);
        let again = Scene::parse(&scene.with_defaults().to_json(), "again").unwrap();
        assert_eq!(again.build().unwrap(), bodies);
        let last = scene.final_scene(&bodies, 1.0);
        assert_eq!(Scene::parse(&last.to_json(), "last").unwrap().build().unwrap(), bodies);
        assert!(
            last.bodies[0].orientation.is_some() && last.bodies[0].axis.is_none() && last.bodies[0].angle.is_none()
        );
    }
    assert_eq!(built(true, &json!({})).1.orientation[0], DQuat::IDENTITY);
}

#[test]
fn two_of_them_and_what_has_no_direction_are_refused() {
    let cases = [
        (true, json!({"axis": [1, 0, 0], "angle": 3}), "angle", "omit one of them"),
        (false, json!({"orientation": [1, 0, 0, 0], "axis": [1, 0, 0]}), "axis", "omit one of them"),
        (true, json!({"orientation": [1, 0, 0, 0], "angle": 0}), "angle", "omit one of them"),
        (false, json!({"axis": [0, 0, 0]}), "axis", "direction"),
        (false, json!({"angle": 3}), "angle", "`axis`"),
        (true, json!({"axis": [1, 0, 1]}), "axis", "mirrored by the plane"),
    ];
    for (planar, keys, key, word) in cases {
        let (at, message) = refusal(&scene(planar, &keys));
        assert!(at == format!("bodies.0.{key}") && message.contains(word), "{message}");
    }
}
