//! Walls in scene files, in what is placed by rule, and in the program's reports.

use relcp::gpu::GpuError;
use relcp::internals::backend::gpu::Device;
use relcp::scene::{self, FaultKind, Method, Scene, SceneError, Wall};
use serde_json::{Value, json};

/// A scene of one rod along z at `z`, its walls on one line each.
fn text(walls: &str, z: f64, more: &str) -> String {
    format!(
        r#"{{ "name": "walls", "time": {{ "dt": 0.1, "end": 1 }}, {more}
  "walls": [
    {walls}
  ],
  "bodies": [
    {{ "shape": {{ "spherocylinder": {{ "diameter": 1, "length": 3 }} }},
      "position": [0, 0, {z}] }}
  ] }}"#
    )
}

fn refused(walls: &str, z: f64, more: &str) -> SceneError {
    Scene::parse(&text(walls, z, more), "test").unwrap_err()
}

#[test]
fn walls_are_read_and_come_back() {
    let all = r#"{ "half_space": { "normal": [0, 0, 2], "offset": -2 } },
    { "channel": { "normal": [0, 1, 1], "center": [0, 0, 0], "width": 6 } },
    { "box": { "minimum": [-9, -9, -9], "maximum": [9, 9, 9] } },
    { "sphere": { "center": [0, 0, 0], "radius": 10 } },
    { "cylinder": { "center": [0, 0, 0], "axis": [0, 0, 1], "radius": 4 } },
    { "cylinder": { "center": [0, 0, 0], "axis": [0, 0, 1], "radius": 4, "length": 7 } }"#;
    let scene = Scene::parse(&text(all, 0.0, ""), "test").unwrap();
    assert_eq!(scene.walls.len(), 6);
    assert_eq!(Scene::parse(&scene.to_json(), "written").unwrap(), scene);
    let counts: Vec<usize> = scene.walls.iter().map(|wall| wall.surfaces(false).len()).collect();
    assert_eq!(counts, [1, 2, 6, 1, 1, 3]);
    let walls = scene.walls();
    assert_eq!((walls.len(), walls.wall_of(0), walls.wall_of(2), walls.wall_of(13)), (14, 0, 1, 5));
    // In the plane, faces across it are left out.
    assert_eq!(scene.walls[2].surfaces(true).len(), 4);
    assert_eq!(scene.walls[5].surfaces(true).len(), 1);
    let schema = scene::schema().to_string();
    for name in ["walls", "half_space", "channel", "cylinder"] {
        assert!(schema.contains(&format!("\"{name}\"")), "{name}");
    }
    // A rod along z between floor and sphere: 1.5 down to its tip, the floor at -2.
    let near = walls.contacts(&scene.build().unwrap(), 0.6);
    assert_eq!(near.len(), 1);
    assert!(near[0].wall == 0 && near[0].body == 0 && (near[0].separation - 0.5).abs() < 1e-15);
    // A scene without walls is written as before.
    assert!(!Scene::built_in("two-ellipsoids").unwrap().to_json().contains("walls"));
}

#[test]
fn bad_walls_are_refused_with_their_place() {
    let cases = [
        (r#"{ "half_space": { "normal": [0, 0, 0], "offset": -2 } }"#, "walls.0.half_space.normal", "direction"),
        (r#"{ "half_space": { "normal": [0, 0, 1e-7], "offset": -2 } }"#, "walls.0.half_space.normal", "direction"),
        (r#"{ "half_space": { "normal": [0, 0, 1e99], "offset": -2 } }"#, "walls.0.half_space.normal.2", "at most"),
        (r#"{ "half_space": { "normal": [0, 0, 1], "offset": -1e40 } }"#, "walls.0.half_space", "coarser"),
        (r#"{ "half_space": { "normal": [0, 0, 1] } }"#, "walls.0.half_space.offset", "missing"),
        (r#"{ "half_space": { "normal": [0, 1], "offset": 0 } }"#, "walls.0.half_space.normal", "list of length 3"),
        (r#"{ "half_plane": {} }"#, "walls.0.half_plane", "half_space"),
        (r#"{ "sphere": { "center": [0, 0, 0], "radius": 0 } }"#, "walls.0.sphere.radius", "positive"),
        (r#"{ "sphere": { "centre": [0, 0, 0], "radius": 9 } }"#, "walls.0.sphere.centre", "center"),
        (r#"{ "sphere": { "center": [0, 0, 0], "radius": -3 } }"#, "walls.0.sphere.radius", "positive"),
        (
            r#"{ "cylinder": { "center": [0, 0, 0], "axis": [0, 0, 0], "radius": 9 } }"#,
            "walls.0.cylinder.axis",
            "direction",
        ),
        (
            r#"{ "cylinder": { "center": [0, 0, 0], "axis": [0, 0, 1], "radius": 9, "length": 0 } }"#,
            "walls.0.cylinder.length",
            "positive",
        ),
        (
            r#"{ "channel": { "normal": [1, 0, 0], "center": [0, 0, 0], "width": 0 } }"#,
            "walls.0.channel.width",
            "positive",
        ),
        (r#"{ "box": { "minimum": [-1, -1, 3], "maximum": [1, 1, 3] } }"#, "walls.0.box.maximum.2", "minimum"),
    ];
    for (wall, key, words) in cases {
        let error = refused(wall, 0.0, "");
        assert_eq!(error.key(), key, "{wall}: {error}");
        assert!(error.message().contains(words), "{wall}: {error}");
        assert_eq!(error.line(), Some(3), "{wall}: {error}");
        assert!(error.column().unwrap() >= 5 && error.kind() != FaultKind::Io, "{wall}: {error}");
    }
    let many = vec![r#"{ "sphere": { "center": [0, 0, 0], "radius": 9 } }"#; 1001].join(",");
    assert_eq!(refused(&many, 0.0, "").kind(), FaultKind::TooLarge);
}

#[test]
fn walls_of_a_planar_scene_stand_upright() {
    let planar = |wall: &str| {
        let text = text(wall, 0.0, r#""planar": true,"#)
            .replace("\"position\"", "\"orientation\": [1, 0, 1, 0], \"position\"");
        Scene::parse(&text, "test")
    };
    let cases = [
        (r#"{ "half_space": { "normal": [0, 1, 0.1], "offset": -2 } }"#, "walls.0.half_space.normal.2"),
        (r#"{ "channel": { "normal": [0, 0, 1], "center": [0, 0, 0], "width": 5 } }"#, "walls.0.channel.normal.2"),
        (r#"{ "sphere": { "center": [0, 0, 1], "radius": 9 } }"#, "walls.0.sphere.center.2"),
        (r#"{ "cylinder": { "center": [0, 0, 0], "axis": [0, 1, 1], "radius": 9 } }"#, "walls.0.cylinder.axis.2"),
        (r#"{ "cylinder": { "center": [0, 0, 2], "axis": [0, 1, 0], "radius": 9 } }"#, "walls.0.cylinder.center.2"),
    ];
    for (wall, key) in cases {
        assert_eq!(planar(wall).unwrap_err().key(), key, "{wall}");
    }
    for wall in [
        r#"{ "cylinder": { "center": [0, 0, 7], "axis": [0, 0, -3], "radius": 9, "length": 1 } }"#,
        r#"{ "cylinder": { "center": [0, 0, 0], "axis": [1, 1, 0], "radius": 9, "length": 9 } }"#,
        r#"{ "box": { "minimum": [-5, -5, 2], "maximum": [5, 5, 3] } }"#,
    ] {
        planar(wall).unwrap();
    }
}

#[test]
fn bodies_that_start_outside_are_refused() {
    let floor = r#"{ "half_space": { "normal": [0, 0, 1], "offset": 0 } }"#;
    Scene::parse(&text(floor, 1.5, ""), "test").unwrap();
    Scene::parse(&text(floor, 1.499_995, ""), "test").unwrap();
    let error = refused(floor, 1.4, "");
    assert_eq!((error.key(), error.line(), error.column()), ("bodies.0.position", Some(7), Some(19)));
    assert!(error.message().contains("0.1 past wall 0 (half_space)"), "{error}");
    // One that a run left there is not: a method without recursion may leave it.
    let lineage = r#""lineage": { "id": 0, "parent": null, "birth": 0, "generation": 0 }, "position""#;
    Scene::parse(&text(floor, 1.4, "").replace("\"position\"", lineage), "test").unwrap();

    let generated = |rule: Value, walls: Value| -> Result<Scene, SceneError> {
        let scene = json!({"name": "generated", "time": {"dt": 0.1, "end": 1}, "generate": [rule], "walls": walls});
        let scene = Scene::parse(&scene.to_string(), "test")?;
        scene.build().map(|_| scene)
    };
    let founder = json!({"founder": {"diameter": 0.5, "length": 2}});
    let error = generated(founder.clone(), json!([{"sphere": {"center": [3, 0, 0], "radius": 3.5}}])).unwrap_err();
    assert_eq!((error.key(), error.kind()), ("generate.0.founder", FaultKind::Placement));
    generated(founder, json!([{"sphere": {"center": [3, 0, 0], "radius": 5}}])).unwrap();
    let mail = json!({"chainmail": {"columns": 3, "rows": 3, "major_radius": 1, "minor_radius": 0.1}});
    let error =
        generated(mail, json!([{"channel": {"normal": [1, 0, 0], "center": [0, 0, 0], "width": 5}}])).unwrap_err();
    assert_eq!((error.key(), error.kind()), ("generate.0.chainmail", FaultKind::Placement));
    let isotropic = json!({"isotropic": {"count": 40, "shape": {"ellipsoid": {"radii": [0.3, 0.4, 0.6]}}, "volume_fraction": 0.05}});
    let ball =
        json!([{"sphere": {"center": [0, 0, 0], "radius": 4}}, {"half_space": {"normal": [1, 0, 0], "offset": -1}}]);
    let scene = generated(isotropic.clone(), ball).unwrap();
    assert_eq!(scene.walls().max_overlap(&scene.build().unwrap()), 0.0);
    let error = generated(isotropic, json!([{"sphere": {"center": [50, 0, 0], "radius": 4}}])).unwrap_err();
    assert_eq!(error.kind(), FaultKind::Placement);
    assert!(error.help_text().unwrap().contains("walls"));
}

#[test]
fn a_device_has_walls_but_for_sub_spheres() {
    let mut scene = Scene::built_in("three-capsules").unwrap();
    scene.walls =
        vec![Wall::HalfSpace { normal: [0.0, 0.0, 1.0], offset: -9.0, motion: None, friction: None, load: None }];
    Device::check(&scene.model()).unwrap();
    scene.contact.method = Method::Multisphere { count: 5 };
    assert_eq!(Device::check(&scene.model()), Err(GpuError::Unsupported { what: "multi-sphere rows".into() }));
}

// ---- the program ----

fn relcp(folder: &std::path::Path, arguments: &[&str]) -> (i32, String, String) {
    let mut program = assert_cmd::Command::cargo_bin("relcp").unwrap();
    let output = program.current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// A method that does not recur leaves a body past a wall, and everything says so.
#[test]
fn an_overlap_with_a_wall_is_reported() {
    let place = tempfile::tempdir().unwrap();
    let ball =
        r#"{ "sphere": { "center": [0, 0, 0], "radius": 10 } }, { "sphere": { "center": [0, 0, 0], "radius": 1.6 } }"#;
    let more = r#""contact": { "method": "snsd" }, "forces": [ { "uniform": { "force": [9, 0, 9] } } ],"#;
    std::fs::write(place.path().join("scene.json"), text(ball, 0.0, more)).unwrap();
    let (status, out, error) = relcp(place.path(), &["run", "scene.json", "--out", "run", "--backend", "cpu"]);
    assert_eq!(status, 3, "{out} {error}");
    assert!(format!("{out}{error}").contains("body 0 and wall 1"), "{out} {error}");
    let read =
        |path: &str| -> Value { serde_json::from_slice(&std::fs::read(place.path().join(path)).unwrap()).unwrap() };
    let summary = read("run/summary.json");
    assert_eq!(summary["first_over_tolerance"][0]["wall"], json!([0, 1]));
    assert!(summary["final_max_overlap"].as_f64().unwrap() > 1e-5);
    for state in ["run", "run/final.json"] {
        let (status, out, error) = relcp(place.path(), &["contacts", state, "--json"]);
        assert_eq!(status, 0, "{error}");
        let report: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(report["max_overlap"], summary["final_max_overlap"]);
        assert_eq!((&report["walls"][0]["body"], &report["walls"][0]["wall"]), (&json!(0), &json!(1)));
    }
    let (_, out, _) = relcp(place.path(), &["contacts", "run"]);
    let words: Vec<Vec<&str>> = out.lines().map(|line| line.split_whitespace().collect()).collect();
    assert!(words[0] == ["body", "wall", "id", "separation"] && words[1][..3] == ["0", "1", "0"], "{out}");
    // The same with recursion holds, and goes on from its checkpoint.
    let recurring = text(ball, 0.0, &more.replace("snsd", "relcp"));
    std::fs::write(place.path().join("scene.json"), recurring).unwrap();
    let (status, out, error) = relcp(place.path(), &["run", "scene.json", "--out", "held", "--backend", "cpu"]);
    assert_eq!(status, 0, "{out} {error}");
    assert!(read("held/summary.json")["final_max_overlap"].as_f64().unwrap() <= 1e-5);
    let (status, _, error) =
        relcp(place.path(), &["run", "scene.json", "--out", "held", "--resume", "--backend", "cpu"]);
    assert_eq!(status, 0, "{error}");
}
