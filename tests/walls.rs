//! Bodies against fixed surfaces: separations against brute force over the bodies' surfaces; walls in scene files and in the program's reports.
#![allow(clippy::unwrap_used)]

use glam::{DQuat, DVec3, DVec4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::backend::gpu::Device;
use relcp::gpu::GpuError;
use relcp::scene::{self, FaultKind, Scene, SceneError, Wall};
use relcp::separation::{Placed, Surface};
use relcp::shape::Shape;
use relcp::walls::Walls;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const KINDS: [&str; 4] = ["sphere", "spherocylinder", "ellipsoid", "torus"];
const POSES: usize = 30;

fn turn(random: &mut ChaCha8Rng) -> DQuat {
    loop {
        let v = DVec4::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        if (0.01..1.0).contains(&v.length_squared()) {
            return DQuat::from_vec4(v.normalize());
        }
    }
}

fn shape(kind: &str, aspect: f64, random: &mut ChaCha8Rng) -> Shape {
    let mut ratio = || aspect.powf(random.random_range(0.0..1.0));
    match kind {
        "sphere" => Shape::Sphere { radius: ratio() },
        "spherocylinder" => Shape::Spherocylinder { diameter: 1.0, length: ratio() },
        "ellipsoid" => Shape::Ellipsoid { radii: [ratio(), 1.0, ratio()] },
        _ => Shape::Torus { major_radius: 1.0 + ratio(), minor_radius: 0.5 },
    }
}

/// A point of the surface by two parameters in the unit square.
fn surface_point(body: &Placed, u: f64, v: f64) -> DVec3 {
    let ball = |u: f64, v: f64| {
        let (polar, azimuth) = (PI * u, TAU * v);
        DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
    };
    let local = match body.shape {
        Shape::Sphere { radius } => radius * ball(u, v),
        Shape::Spherocylinder { diameter, length } => {
            let n = ball(u, v);
            0.5 * diameter * n + DVec3::Z * (0.5 * (length - diameter)).copysign(n.z)
        }
        Shape::Ellipsoid { radii } => DVec3::from_array(radii) * ball(u, v),
        Shape::Torus { major_radius, minor_radius } => {
            let ((s, c), (t, d)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
            DVec3::new((major_radius + minor_radius * d) * c, (major_radius + minor_radius * d) * s, minor_radius * t)
        }
    };
    body.position + body.orientation * local
}

/// How far a point is inside, by definition.
fn inside(surface: &Surface, p: DVec3) -> f64 {
    match *surface {
        Surface::Plane { point, normal } => (p - point).dot(normal),
        Surface::Sphere { centre, radius } => radius - p.distance(centre),
        Surface::Cylinder { centre, axis, radius } => radius - (p - centre).cross(axis).length(),
    }
}

/// The least of `inside` over the body: a grid, then ever finer grids about the best few places.
fn brute_force(surface: &Surface, body: &Placed) -> f64 {
    const SIDE: usize = 60;
    let at = |u: f64, v: f64| inside(surface, surface_point(body, u, v));
    let mut grid: Vec<(f64, f64, f64)> = (0..=SIDE)
        .flat_map(|i| (0..=SIDE).map(move |j| (i as f64 / SIDE as f64, j as f64 / SIDE as f64)))
        .map(|(u, v)| (at(u, v), u, v))
        .collect();
    grid.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refine = |&(value, u, v): &(f64, f64, f64)| {
        let (mut best, mut width) = ((value, u, v), 1.0 / SIDE as f64);
        while width > 1e-9 {
            let (_, u, v) = best;
            for i in -3..=3 {
                for j in -3..=3 {
                    let (u, v) = (u + width * f64::from(i) / 3.0, v + width * f64::from(j) / 3.0);
                    let value = at(u, v);
                    if value < best.0 {
                        best = (value, u, v);
                    }
                }
            }
            width *= 0.6;
        }
        best.0
    };
    grid.iter().take(8).map(refine).fold(f64::INFINITY, f64::min)
}

fn surfaces(random: &mut ChaCha8Rng, size: f64) -> [Surface; 3] {
    let unit = |random: &mut ChaCha8Rng| turn(random) * DVec3::Z;
    let centre = size * unit(random) * random.random_range(0.0..1.0);
    let radius = size * random.random_range(0.5..4.0);
    [
        Surface::Plane { point: centre, normal: unit(random) },
        Surface::Sphere { centre, radius },
        Surface::Cylinder { centre, axis: unit(random), radius },
    ]
}

fn check(surface: &Surface, body: &Placed) -> f64 {
    let found = surface.separation(body);
    let size = body.shape.bounding_radius() + 1.0;
    assert!(found.normal.is_normalized() && found.lever_b == DVec3::ZERO, "{found:?}");
    // The touching point lies on the surface of the body and has the gap that is told, along the normal that is told.
    let point = body.position + found.lever_a;
    assert!((inside(surface, point) - found.separation).abs() < 1e-9 * size, "{surface:?} {body:?}: {found:?}");
    assert!(inside(surface, point + found.separation * found.normal).abs() < 1e-9 * size);
    assert!(surface.bound(body) <= found.separation + 1e-12 * size);
    (found.separation - brute_force(surface, body)).abs() / size
}

#[test]
fn separations_are_the_least_over_the_surface_of_the_body() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for kind in KINDS {
        let mut worst = [0.0_f64; 3];
        for pose in 0..POSES {
            let aspect = [2.0, 5.0][pose % 2];
            let shape = shape(kind, aspect, &mut random);
            for (k, surface) in surfaces(&mut random, aspect).iter().enumerate() {
                let position = (turn(&mut random) * DVec3::X) * aspect * random.random_range(0.0..1.0);
                let body = Placed { shape, position, orientation: turn(&mut random) };
                worst[k] = worst[k].max(check(surface, &body));
            }
        }
        println!("{kind}: plane {:.1e}, sphere {:.1e}, cylinder {:.1e}", worst[0], worst[1], worst[2]);
        assert!(worst.iter().all(|w| *w < 1e-8), "{kind}: {worst:?}");
    }
}

/// Poses where the farthest point is not unique, or a direction vanishes.
#[test]
fn symmetric_poses_have_a_separation_too() {
    let orientations = [DQuat::IDENTITY, DQuat::from_rotation_x(0.5 * PI), DQuat::from_rotation_y(0.5 * PI)];
    let shapes = [
        Shape::Sphere { radius: 1.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 1.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 3.0 },
        Shape::Ellipsoid { radii: [1.0, 1.0, 1.0] },
        Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] },
        Shape::Ellipsoid { radii: [2.0, 2.0, 1.0] },
        Shape::Ellipsoid { radii: [1.0, 1.5, 2.0] },
        Shape::Torus { major_radius: 1.0, minor_radius: 0.2 },
    ];
    let walls = [
        Surface::Plane { point: DVec3::ZERO, normal: DVec3::Z },
        Surface::Sphere { centre: DVec3::ZERO, radius: 3.0 },
        Surface::Cylinder { centre: DVec3::ZERO, axis: DVec3::Z, radius: 3.0 },
    ];
    let mut worst = 0.0_f64;
    for shape in shapes {
        for orientation in orientations {
            for position in [DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.3, DVec3::Z * 0.2, DVec3::new(0.2, 0.0, 0.4)] {
                for surface in &walls {
                    worst = worst.max(check(surface, &Placed { shape, position, orientation }));
                }
            }
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-8);
}

#[test]
fn thin_and_flat_bodies_keep_their_digits() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut worst = 0.0_f64;
    for _ in 0..200 {
        for radii in [[1.0, 1.0, 1000.0], [1000.0, 1000.0, 1.0], [1.0, 30.0, 1000.0]] {
            let body = Placed {
                shape: Shape::Ellipsoid { radii },
                position: 500.0 * (turn(&mut random) * DVec3::X),
                orientation: turn(&mut random),
            };
            for surface in surfaces(&mut random, 1000.0) {
                let found = surface.separation(&body);
                let (point, size) = (body.position + found.lever_a, 2000.0);
                // On the ellipsoid, and its normal there is the surface's.
                let on = (body.orientation.inverse() * found.lever_a) / DVec3::from_array(radii);
                assert!((on.length() - 1.0).abs() < 1e-9, "{on}");
                assert!((inside(&surface, point) - found.separation).abs() < 1e-12 * size);
                let normal = body.orientation * (on / DVec3::from_array(radii));
                // By definition nothing of the body is beyond its tangent plane; the separation is then not less than this bound.
                let reach = (DVec3::from_array(radii) * (body.orientation.inverse() * found.normal)).length();
                worst = worst.max((reach - found.lever_a.dot(found.normal)).abs() / size);
                assert!(normal.dot(found.normal) > 0.0);
            }
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}

// ---- scenes ----

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
    scene::parse(&text(walls, z, more), "test").unwrap_err()
}

#[test]
fn walls_are_read_and_come_back() {
    let all = r#"{ "half_space": { "normal": [0, 0, 2], "offset": -2 } },
    { "channel": { "normal": [0, 1, 1], "center": [0, 0, 0], "width": 6 } },
    { "box": { "minimum": [-9, -9, -9], "maximum": [9, 9, 9] } },
    { "sphere": { "center": [0, 0, 0], "radius": 10 } },
    { "cylinder": { "center": [0, 0, 0], "axis": [0, 0, 1], "radius": 4 } },
    { "cylinder": { "center": [0, 0, 0], "axis": [0, 0, 1], "radius": 4, "length": 7 } }"#;
    let scene = scene::parse(&text(all, 0.0, ""), "test").unwrap();
    assert_eq!(scene.walls.len(), 6);
    assert_eq!(scene::parse(&scene.to_json(), "written").unwrap(), scene);
    let counts: Vec<usize> = scene.walls.iter().map(|wall| wall.surfaces(false).len()).collect();
    assert_eq!(counts, [1, 2, 6, 1, 1, 3]);
    let walls = Walls::of(&scene);
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
    assert!(near[0].wall == 0 && near[0].body == 0 && (near[0].found.separation - 0.5).abs() < 1e-15);
    // A scene without walls is written as before.
    assert!(!scene::load("two-ellipsoids", &[]).unwrap().to_json().contains("walls"));
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
        assert!(error.column().unwrap() >= 5 && error.exit_code() == 2, "{wall}: {error}");
    }
    let many = vec![r#"{ "sphere": { "center": [0, 0, 0], "radius": 9 } }"#; 1001].join(",");
    assert_eq!(refused(&many, 0.0, "").kind(), FaultKind::TooLarge);
}

#[test]
fn walls_of_a_planar_scene_stand_upright() {
    let planar = |wall: &str| {
        let text = text(wall, 0.0, r#""planar": true,"#)
            .replace("\"position\"", "\"orientation\": [1, 0, 1, 0], \"position\"");
        scene::parse(&text, "test")
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
    scene::parse(&text(floor, 1.5, ""), "test").unwrap();
    scene::parse(&text(floor, 1.499_995, ""), "test").unwrap();
    let error = refused(floor, 1.4, "");
    assert_eq!((error.key(), error.line(), error.column()), ("bodies.0.position", Some(7), Some(19)));
    assert!(error.message().contains("1.000e-1 past wall 0 (half_space)"), "{error}");
    // One that a run left there is not: a method without recursion may leave it.
    let lineage = r#""lineage": { "id": 0, "parent": null, "birth": 0, "generation": 0 }, "position""#;
    scene::parse(&text(floor, 1.4, "").replace("\"position\"", lineage), "test").unwrap();

    let generated = |rule: Value, walls: Value| -> Result<Scene, SceneError> {
        let scene = json!({"name": "generated", "time": {"dt": 0.1, "end": 1}, "generate": [rule], "walls": walls});
        let scene = scene::parse(&scene.to_string(), "test")?;
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
    assert_eq!(Walls::of(&scene).max_overlap(&scene.build().unwrap()), 0.0);
    let error = generated(isotropic, json!([{"sphere": {"center": [50, 0, 0], "radius": 4}}])).unwrap_err();
    assert_eq!(error.kind(), FaultKind::Placement);
    assert!(error.help_text().unwrap().contains("walls"));
}

#[test]
fn a_device_has_no_walls() {
    let mut scene = scene::load("three-capsules", &[]).unwrap();
    Device::check(&scene).unwrap();
    scene.walls = vec![Wall::HalfSpace { normal: [0.0, 0.0, 1.0], offset: -9.0 }];
    let refused = Device::check(&scene);
    assert_eq!(refused, Err(GpuError::Unsupported { what: "walls".into() }));
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
    assert!(out.contains("wall  1"), "{out}");
    // The same with recursion holds, and goes on from its checkpoint.
    let recurring = text(ball, 0.0, &more.replace("snsd", "relcp"));
    std::fs::write(place.path().join("scene.json"), recurring).unwrap();
    let (status, out, error) = relcp(place.path(), &["run", "scene.json", "--out", "held", "--backend", "cpu"]);
    assert_eq!(status, 0, "{out} {error}");
    assert!(read("held/summary.json")["final_max_overlap"].as_f64().unwrap() <= 1e-5);
    let (status, _, error) =
        relcp(place.path(), &["run", "scene.json", "--out", "held", "--resume", "--backend", "cpu"]);
    assert_eq!(status, 0, "{error}");
    let (status, _, error) = relcp(place.path(), &["run", "scene.json", "--out", "device", "--backend", "gpu"]);
    assert!(status != 0 && error.contains("walls"), "{status} {error}");
}
