//! Over a hundred broken scenes about bonds, joints, chains and bonds of daughters: each is refused, and the error has
//! the key of what is wrong.

use relcp::scene::Scene;
use serde_json::{Value, json};

/// Three rods, a bond, a joint of each kind, and a chain.
fn whole() -> Value {
    let rod = |i: i32| json!({"shape": {"spherocylinder": {"diameter": 0.25, "length": 1.0}}, "position": [0, 0, 1.2 * f64::from(i)]});
    let ends = json!([[0, 0, 0.6], [0, 0, -0.6]]);
    json!({"name": "whole", "time": {"dt": 0.001, "end": 0.1}, "bodies": (0..5).map(rod).collect::<Vec<_>>(),
        "bonds": [{"bodies": [0, 1], "at": ends, "stiffness": 10.0, "length": 0.1, "break_force": 5.0, "bending": 2.0}],
        "joints": [{"ball": {"bodies": [1, 2], "at": ends}}, {"hinge": {"bodies": [2, 3], "at": ends, "axis": [1, 0, 0]}},
            {"weld": {"bodies": [3, 4], "at": ends}}],
        "generate": [{"chain": {"count": 4, "shape": {"sphere": {"radius": 0.5}}, "stiffness": 10.0,
            "path": {"straight": {"center": [9, 0, 0], "axis": [1, 0, 0]}}}}]})
}

/// A cell whose daughters are bonded.
fn cell() -> Value {
    json!({"name": "cell", "time": {"dt": 0.01, "end": 0.1},
        "growth": {"rate": 1.0, "division_length": 2.0, "bond_daughters": {"stiffness": 10.0}},
        "generate": [{"founder": {"diameter": 0.5, "length": 1.5}}]})
}

/// The scene with a value at a pointer, whose objects are made where they are not.
fn with(mut scene: Value, pointer: &str, value: Value) -> Value {
    let (place, key) = pointer.rsplit_once('/').unwrap();
    let place = scene.pointer_mut(place).unwrap_or_else(|| panic!("{pointer}"));
    match place {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        place => place[key] = value,
    }
    scene
}

fn check(scene: &Value, pointer: &str, value: &Value, under: &str) {
    let broken = with(scene.clone(), pointer, value.clone());
    match Scene::parse(&broken.to_string(), "broken") {
        Ok(_) => panic!("{pointer} = {value} is accepted"),
        Err(error) => {
            assert!(error.key().starts_with(under), "{pointer} = {value}: key {}, not {under}: {error}", error.key());
        }
    }
}

#[test]
fn broken_bonds_and_joints_are_refused_with_their_key() {
    Scene::parse(&whole().to_string(), "whole").unwrap();
    Scene::parse(&cell().to_string(), "cell").unwrap();
    let mut count = 0;
    let mut all = |scene: &Value, pointer: &str, values: Value| {
        let under = pointer.trim_start_matches('/').replace('/', ".");
        for value in values.as_array().unwrap() {
            check(scene, pointer, value, &under);
            count += 1;
        }
    };
    let scene = whole();
    let not_positive = json!([0, -1, "soft", true, null, [1], {"of": 1}]);
    let bad_bodies = json!([[0], [0, 0], [0, 99], [-1, 0], [0, 1, 2], "both", [0.5, 1], null, 3]);
    let bad_at = json!([[0, 0, 0], [[0, 0], [0, 0, 0]], [[0, 0, 0]], "ends", [[0, 0, "z"], [0, 0, 0]], null]);
    let no_flag = json!(["no", 0, [true], null]);
    for place in ["/bonds/0", "/joints/0/ball", "/joints/1/hinge", "/joints/2/weld"] {
        all(&scene, &format!("{place}/bodies"), bad_bodies.clone());
        all(&scene, &format!("{place}/at"), bad_at.clone());
        all(&scene, &format!("{place}/stiffness"), not_positive.clone());
        all(&scene, &format!("{place}/contact"), no_flag.clone());
        all(&scene, &format!("{place}/stiffnes"), json!([1]));
    }
    all(&scene, "/bonds/0/length", json!([-1, "long", null, 1e300]));
    all(&scene, "/bonds/0/break_force", json!([0, -2, "weak"]));
    all(&scene, "/bonds/0/bending", json!([0, -1, "soft", {}, {"stiffness": 0}, {"axes": [[0, 0, 1], [0, 0, 1]]}]));
    all(
        &scene,
        "/bonds/0/bending",
        json!([{"stiffness": 1, "axes": [[0, 0, 0], [0, 0, 1]]}, {"stiffness": 1, "axes": [1]}]),
    );
    all(&scene, "/bonds/0/implicit", json!(["yes", 1, [false]]));
    all(&scene, "/joints/1/hinge/axis", json!([[0, 0, 0], [1, 0], "x", 3]));
    for place in ["/joints/1/hinge", "/joints/2/weld"] {
        all(&scene, &format!("{place}/bending"), json!([0, -1, "soft", true]));
        all(&scene, &format!("{place}/rest"), json!([[0, 0, 0, 0], [1, 0, 0], "as is", 1]));
    }
    all(&scene, "/joints/0", json!([{"pin": {}}, 3]));
    for key in ["stiffness", "bending", "break_force"] {
        all(&scene, &format!("/generate/0/chain/{key}"), json!([0, -1, "soft", true]));
    }
    all(&scene, "/generate/0/chain/count", json!([0, 1, -2, 2.5, "four"]));
    all(&scene, "/generate/0/chain/gap", json!([-0.1, "wide", [1]]));
    all(&scene, "/generate/0/chain/contact", no_flag);
    all(&scene, "/generate/0/chain/path", json!([{"spiral": {}}, "ring", {"straight": {}}]));
    let scene = cell();
    for key in ["stiffness", "bending", "break_force", "gap"] {
        all(&scene, &format!("/growth/bond_daughters/{key}"), json!([0, -1, "soft", true]));
    }
    all(&scene, "/growth/bond_daughters/contact", json!([true]));
    println!("{count} broken scenes");
    assert!(count >= 100);
}
