//! Overrides of keys, as `--set` gives them.

use super::{good, set};
use relcp::scene::{Force, Method, Scene};
use relcp::shape::Shape;

#[test]
fn overrides_reach_every_key() {
    let scene = set(
        "two-ellipsoids",
        &[
            "bodies.0.position.1=3.25",
            "bodies.0.shape.ellipsoid.radii=[1, 1, 3]",
            "forces.1.uniform.force=[0, 2, 0]",
            "forces.2.uniform.force=[0.5, 0, 0]",
            "contact.method.multisphere.count=7",
            "solver.kind=bbpgd",
            "dynamics.inertial.density=2",
            "name=sweep",
        ],
    )
    .unwrap();
    assert_eq!(scene.bodies[0].position[1], 3.25);
    assert_eq!(scene.bodies[0].shape, Shape::Ellipsoid { radii: [1.0, 1.0, 3.0] });
    assert_eq!(scene.forces[1], Force::Uniform { force: [0.0, 2.0, 0.0], group: Some("lower".into()), window: None });
    assert_eq!(scene.forces[2], Force::Uniform { force: [0.5, 0.0, 0.0], group: None, window: None });
    assert_eq!(scene.contact.method, Method::Multisphere { count: 7 });
    assert_eq!(scene.name, "sweep");
    // What was not there is made.
    assert_eq!(set("three-capsules", &["forces.0.uniform.force=[1,0,0]"]).unwrap().forces.len(), 1);
    assert_eq!(set("three-capsules", &["solver.max_iterations=5"]).unwrap().lcp_settings().max_iterations, 5);
}

#[test]
fn bad_overrides_name_themselves_and_the_nearest_key() {
    for (text, key, says) in [
        ("time.dtt=1", "time.dtt", "nearest is `dt`"),
        ("contat.method=snsd", "contat", "nearest is `contact`"),
        ("time.dt=fast", "time.dt", "expected a number"),
        ("time.dt=-1", "time.dt", "must be positive"),
        ("bodies.0.position.1=NaN", "bodies.0.position.1", "expected a number"),
        ("bodies.0.shape.elipsoid.radii=[1,1,1]", "bodies.0.shape.elipsoid", "nearest is `ellipsoid`"),
        ("bodies.9.position.1=1", "bodies.9", "index from 0 to 2"),
        ("name.x=1", "name.x", "single value"),
        ("forces.0.uniform.group=uper", "forces.0.uniform.group", "nearest group is `upper`"),
        ("solver.kind=bbpg", "solver.kind", "nearest is `bbpgd`"),
    ] {
        let error = set("two-ellipsoids", &[text]).unwrap_err();
        assert_eq!(error.key(), key, "{error}");
        assert!(error.message().contains(says), "{error}");
        assert_eq!((error.origin(), error.line()), (Some(format!("override {text}").as_str()), None), "{error}");
    }
    // A fault of the file itself stays in the file, also with overrides, and repeated keys are still seen.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.json");
    for (broken, key) in [("\"dt\": 0.01, \"dt\": 1", "time.dt"), ("\"dt\": 0", "time.dt"), ("\"tt\": 1", "time.tt")] {
        std::fs::write(&file, good().to_json().replace("\"dt\": 0.01", broken)).unwrap();
        let error = Scene::load(&file, ["output.step_stride=2"]).unwrap_err();
        assert_eq!(error.key(), key, "{error}");
        assert!(error.line() > Some(1), "{error}");
    }
}
