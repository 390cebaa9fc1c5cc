//! Periodic scenes: what is read, what is refused and where, and what is placed by rule.

use crate::audit;
use relcp::internals::backend::gpu::Device;
use relcp::scene::{self, FaultKind, Periodic, Scene, SceneError};
use serde_json::{Value, json};

/// A scene of one rod, its section `periodic` on the third line and `more` on the fourth.
fn text(periodic: &str, more: &str) -> String {
    format!(
        r#"{{ "name": "periodic",
  "time": {{ "dt": 0.1, "end": 1 }},
  "periodic": {periodic},
  {more}
  "bodies": [ {{ "shape": {{ "spherocylinder": {{ "diameter": 1, "length": 3 }} }}, "position": [0, 0, 0], "orientation": [1, 0, 1, 0] }} ] }}"#
    )
}

fn refused(periodic: &str, more: &str) -> SceneError {
    Scene::parse(&text(periodic, more), "test").unwrap_err()
}

#[test]
fn periods_are_read_and_come_back() {
    let scene = Scene::parse(&text(r#"{ "lengths": [8, null, 7.5] }"#, ""), "test").unwrap();
    assert_eq!(scene.periodic, Some(Periodic::new([Some(8.0), None, Some(7.5)])));
    assert_eq!(Scene::parse(&scene.to_json(), "written").unwrap(), scene);
    let last = scene.final_scene(&scene.build().unwrap(), 1.0);
    assert_eq!(last.periodic, scene.periodic);
    let other = Scene::parse(&text(r#"{ "lengths": [8, null, 7.25] }"#, ""), "test").unwrap();
    assert_ne!(relcp::record::scene_hash(&scene), relcp::record::scene_hash(&other));
    let schema = scene::schema();
    assert!(schema["properties"]["periodic"].is_object() && schema.to_string().contains("\"lengths\""));
    // A scene without periods is written as before.
    assert!(!Scene::built_in("two-ellipsoids").unwrap().to_json().contains("periodic"));
    let set = Scene::load("three-capsules", [r#"periodic={"lengths":[40,null,null]}"#, "periodic.lengths.1=30"]);
    assert_eq!(set.unwrap().periodic, Some(Periodic::new([Some(40.0), Some(30.0), None])));
}

#[test]
fn bad_periods_are_refused_with_their_place() {
    let cases = [
        ("{}", "periodic.lengths", "missing", 3),
        (r#"{ "lengths": [null, null, null] }"#, "periodic.lengths", "at least one axis", 28),
        (r#"{ "lengths": [8, 0, null] }"#, "periodic.lengths.1", "positive", 32),
        (r#"{ "lengths": [-8, 9, null] }"#, "periodic.lengths.0", "positive", 29),
        (r#"{ "lengths": [8, 9] }"#, "periodic.lengths", "list of length 3", 28),
        (r#"{ "lengths": [8, 9, "a"] }"#, "periodic.lengths.2", "number", 35),
        (r#"{ "length": [8, 9, 9] }"#, "periodic.length", "lengths", 17),
        (r#"{ "lengths": [1e30, 9, 9] }"#, "periodic.lengths.0", "coarser", 29),
        (r#"[8, 9, 9]"#, "periodic", "found a list", 15),
        (r#"[[8, 9, 9]]"#, "periodic", "list", 15),
        // A rod of 3 and a cutoff of 0.1 need 6.2.
        (r#"{ "lengths": [8, 6.1, 9] }"#, "periodic.lengths.1", "6.2", 32),
    ];
    for (periodic, key, words, column) in cases {
        let error = refused(periodic, "");
        assert_eq!(error.key(), key, "{periodic}: {error}");
        assert!(error.message().contains(words), "{periodic}: {error}");
        assert_eq!((error.line(), error.column()), (Some(3), Some(column)), "{periodic}: {error}");
        assert_ne!(error.kind(), FaultKind::Io);
    }
    Scene::parse(&text(r#"{ "lengths": [8, 6.3, 9] }"#, ""), "test").unwrap();
}

#[test]
fn what_has_no_periods_is_refused_in_a_periodic_scene() {
    let all = r#"{ "lengths": [9, 9, 9] }"#;
    let x = r#"{ "lengths": [9, null, null] }"#;
    let wall = |wall: &str| format!(r#""walls": [ {wall} ],"#);
    let channel = wall(r#"{ "channel": { "normal": [0, 1, 0], "center": [0, 0, 0], "width": 5 } }"#);
    let pipe = wall(r#"{ "cylinder": { "center": [0, 0, 0], "axis": [-2, 0, 0], "radius": 3 } }"#);
    let cases = [
        (x, r#""forces": [ { "radial_inward": {} } ],"#.to_owned(), "forces.0.radial_inward"),
        (
            all,
            r#""forces": [ { "uniform": { "force": [1, 0, 0] } }, { "radial_outward": {} } ],"#.to_owned(),
            "forces.1.radial_outward",
        ),
        (all, channel.clone(), "walls.0.channel"),
        (r#"{ "lengths": [null, 9, null] }"#, pipe.clone(), "walls.0.cylinder"),
        (
            x,
            wall(r#"{ "cylinder": { "center": [0, 0, 0], "axis": [1, 0, 0], "radius": 3, "length": 9 } }"#),
            "walls.0.cylinder",
        ),
        (x, wall(r#"{ "sphere": { "center": [0, 0, 0], "radius": 9 } }"#), "walls.0.sphere"),
        (x, wall(r#"{ "box": { "minimum": [-5, -5, -5], "maximum": [5, 5, 5] } }"#), "walls.0.box"),
        (x, wall(r#"{ "half_space": { "normal": [1e-9, 1, 0], "offset": -5 } }"#), "walls.0.half_space"),
        (
            x,
            r#""growth": { "rate": 1, "division_length": 3, "stop": { "radius": 9 } },"#.to_owned(),
            "growth.stop.radius",
        ),
        // It grows to 4.4, which with the cutoff takes 9.04.
        (x, r#""growth": { "rate": 1, "division_length": 4 },"#.to_owned(), "periodic.lengths.0"),
        (all, r#""planar": true,"#.to_owned(), "periodic.lengths.2"),
    ];
    for (periodic, more, key) in cases {
        let error = refused(periodic, &more);
        assert_eq!(error.key(), key, "{more}: {error}");
        let line = if key.starts_with("periodic") { 3 } else { 4 };
        assert_eq!((error.line(), error.kind()), (Some(line), FaultKind::BadValue), "{more}: {error}");
    }
    for (periodic, more) in [(x, channel.as_str()), (x, pipe.as_str()), (x, r#""planar": true,"#)] {
        Scene::parse(&text(periodic, more), "test").unwrap();
    }
    let longer = r#"{ "lengths": [9.5, null, null] }"#;
    Scene::parse(&text(longer, r#""growth": { "rate": 1, "division_length": 4 },"#), "test").unwrap();
}

#[test]
fn a_device_takes_periods() {
    let mut scene = Scene::built_in("three-capsules").unwrap();
    scene.periodic = Some(Periodic::new([Some(50.0), None, None]));
    Device::check(&scene.model()).unwrap();
}

fn generated(lengths: Value, planar: bool, rules: Value) -> Result<relcp::bodies::Bodies, SceneError> {
    let scene = json!({"name": "generated", "seed": 4, "planar": planar, "time": {"dt": 0.1, "end": 1},
        "periodic": {"lengths": lengths}, "generate": rules});
    Scene::parse(&scene.to_string(), "test")?.build()
}

#[test]
fn placed_bodies_keep_clear_of_images() {
    let rule = |shape: Value, count: u64, fraction: f64| json!({"isotropic": {"count": count, "shape": shape, "volume_fraction": fraction}});
    let rod = json!({"spherocylinder": {"diameter": 0.5, "length": 2.5}});
    let ball = json!({"sphere": {"radius": 0.5}});
    // The fractions: 200 rods of 0.4581 in 720, half as much and an open axis, 90 discs of 0.7854 in 180, and in a
    // channel.
    let volume = std::f64::consts::PI * (0.25 * 0.25 * 2.0 + 0.5_f64.powi(3) / 6.0);
    let disc = std::f64::consts::PI * 0.25;
    for (lengths, planar, rule) in [
        (json!([8, 9, 10]), false, rule(rod.clone(), 200, 200.0 * volume / 720.0)),
        (json!([8, null, 10]), false, rule(rod.clone(), 200, 0.1)),
        (json!([null, 9, null]), false, rule(rod.clone(), 200, 0.1)),
        (json!([12, 15, null]), true, rule(ball.clone(), 90, 90.0 * disc / 180.0)),
        (json!([12, null, null]), true, rule(ball.clone(), 90, 0.4)),
    ] {
        let bodies = generated(lengths.clone(), planar, json!([rule])).unwrap();
        assert_eq!(audit(&bodies), 0.0, "{lengths}");
        let (mut low, mut high) = (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY);
        bodies.position.iter().for_each(|x| (low, high) = (low.min(*x), high.max(*x)));
        let mut open = bodies.clone();
        open.periods = relcp::periodic::Periods::NONE;
        for (axis, length) in bodies.periods.lengths().into_iter().enumerate() {
            let Some(length) = length else { continue };
            // The whole period is used, and not more.
            assert!(high[axis] - low[axis] > 0.9 * length && high[axis] < 0.5 * length && low[axis] >= -0.5 * length);
        }
        // By density: the open axes make up for the rest.
        let near = |bodies: &relcp::bodies::Bodies| relcp::step::contacts(bodies, 0.3).len();
        assert!(near(&bodies) > near(&open), "{lengths}: some are near through a boundary only");
    }
}

#[test]
fn rules_that_do_not_fill_or_fit_the_cell_are_refused() {
    let rule = |fraction: f64| json!([{"isotropic": {"count": 10, "shape": {"sphere": {"radius": 0.5}}, "volume_fraction": fraction}}]);
    let error = generated(json!([4, 4, 4]), false, rule(0.05)).unwrap_err();
    assert_eq!(error.key(), "generate.0.isotropic.volume_fraction");
    assert!(error.message().contains("0.0818"), "{error}");
    generated(json!([4, 4, 4]), false, rule(0.082)).unwrap();
    let mail = json!([{"chainmail": {"columns": 3, "rows": 3, "major_radius": 1, "minor_radius": 0.1}}]);
    let error = generated(json!([null, 5.3, null]), false, mail.clone()).unwrap_err();
    assert_eq!((error.key(), error.kind()), ("generate.0.chainmail", FaultKind::Placement));
    assert!(error.message().contains("sheet"), "{error}");
    generated(json!([null, 5.5, null]), false, mail).unwrap();
}
