//! GSD files: structure, counts and values.

use crate::gsd_file::{read, shapes};
use crate::scenes::{colony, every_shape, many_rods};
use glam::{DVec3, Vec3};
use relcp::bodies::NO_GROUP;
use relcp::export::{ExportError, gsd};
use relcp::record::{Snapshot, States};
use relcp::shape::Shape;
use serde_json::{Value, json};
use std::path::PathBuf;

fn written(folder: &tempfile::TempDir, states: &States) -> (PathBuf, relcp::export::Exported) {
    let path = folder.path().join("out.gsd");
    let done = gsd(states, &path, &mut |_, _| true).unwrap();
    assert_eq!(done.bytes, std::fs::metadata(&path).unwrap().len());
    assert_eq!(done.files, std::slice::from_ref(&path));
    (path, done)
}

/// Whether a type's shape is a body's, to so much.
fn draws(of: &Value, shape: &Shape, off: f64) -> bool {
    let near = |value: &Value, to: f64| (value.as_f64().unwrap() - to).abs() <= off;
    match *shape {
        Shape::Sphere { radius } => of["type"] == "Sphere" && near(&of["diameter"], 2.0 * radius),
        Shape::Spherocylinder { diameter, length } if diameter == length => {
            of["type"] == "Sphere" && near(&of["diameter"], diameter)
        }
        Shape::Spherocylinder { diameter, length } => {
            let half = 0.5 * (length - diameter);
            let corner = |i: usize, z: f64| near(&of["vertices"][i][2], z) && of["vertices"][i][0] == 0.0;
            of["type"] == "ConvexPolyhedron"
                && near(&of["rounding_radius"], 0.5 * diameter)
                && of["vertices"].as_array().unwrap().len() == 2
                && corner(0, -half)
                && corner(1, half)
        }
        Shape::Ellipsoid { radii } => {
            of["type"] == "Ellipsoid"
                && near(&of["a"], radii[0])
                && near(&of["b"], radii[1])
                && near(&of["c"], radii[2])
        }
        Shape::Torus { major_radius, minor_radius } => {
            let on = |corner: &Value| {
                let x = DVec3::from_array([0, 1, 2].map(|i| corner[i].as_f64().unwrap()));
                ((x.truncate().length() - major_radius).hypot(x.z) - minor_radius).abs() < 1e-6
            };
            let corners = of["vertices"].as_array().unwrap();
            of["type"] == "Mesh" && corners.len() == 96 * 24 && corners.iter().all(on)
        }
        _ => false,
    }
}

#[test]
fn every_shape_is_there_with_its_own_type() {
    let folder = tempfile::tempdir().unwrap();
    let state = every_shape();
    let (path, done) = written(&folder, &States::single("mixed", state.clone()));
    assert_eq!((done.states, done.bodies), (1, 40));
    let frames = read(&path);
    assert_eq!(frames.len(), 1);
    let frame = &frames[0];
    let Snapshot { bodies, .. } = &state;
    assert_eq!(frame["configuration/step"].u64s(), [12]);
    assert_eq!(frame["particles/N"].u32s(), [40]);
    assert_eq!(frame["log/time"].f64s(), [0.1 + 0.2]);
    let (types, drawn) = (frame["particles/types"].texts(), shapes(frame));
    assert_eq!((types.len(), drawn.len()), (40, 40));
    let (typeid, position) = (frame["particles/typeid"].u32s(), frame["particles/position"].f32s());
    let (turns, velocity) = (frame["particles/orientation"].f32s(), frame["particles/velocity"].f32s());
    let sides = frame["configuration/box"].f32s();
    assert_eq!(sides[3..], [0.0; 3]);
    let (ids, parents) = (frame["log/particles/id"].i64s(), frame["log/particles/parent"].i64s());
    let (births, generations) = (frame["log/particles/birth"].f64s(), frame["log/particles/generation"].u32s());
    let (groups, sizes) = (frame["log/particles/group"].i32s(), frame["log/particles/size"].f64s());
    let spins = frame["log/particles/angular_velocity"].f64s();
    for i in 0..40 {
        let of = typeid[i] as usize;
        assert!(types[of].starts_with(bodies.shape[i].name()), "{}", types[of]);
        assert!(draws(&drawn[of], &bodies.shape[i], 1e-15), "{i}: {:?} as {}", bodies.shape[i], drawn[of]);
        let vector = |values: &[f32]| Vec3::from_slice(&values[3 * i..]);
        assert_eq!(vector(&position), bodies.position[i].as_vec3());
        assert_eq!(vector(&velocity), bodies.velocity[i].as_vec3());
        let q = bodies.orientation[i].as_quat();
        assert_eq!(turns[4 * i..4 * i + 4], [q.w, q.x, q.y, q.z]);
        let lineage = bodies.lineage[i];
        assert_eq!((ids[i], parents[i]), (lineage.id as i64, lineage.parent.map_or(-1, |id| id as i64)));
        assert_eq!((births[i], generations[i]), (lineage.birth, lineage.generation));
        assert_eq!(groups[i], if bodies.group[i] == NO_GROUP { -1 } else { 1 });
        assert_eq!(sizes[3 * i..3 * i + 3], bodies.shape[i].code().1);
        assert_eq!(spins[3 * i..3 * i + 3], bodies.angular_velocity[i].to_array());
        let reach = bodies.position[i].abs() + bodies.shape[i].half_extents(bodies.orientation[i]);
        assert!((0..3).all(|axis| 2.0 * reach[axis] < f64::from(sides[axis])));
    }
    assert!(!frame.contains_key("log/particles/Aspherical Shape"));
}

#[test]
fn a_growing_colony_is_a_frame_a_state() {
    let folder = tempfile::tempdir().unwrap();
    let states = States::open(colony(folder.path()).path().to_str().unwrap()).unwrap();
    let (path, done) = written(&folder, &states);
    assert_eq!((done.states, done.bodies, states.len()), (26, 8, 26));
    let frames = read(&path);
    assert_eq!(frames.len(), 26);
    let (drawn, sides) = (shapes(&frames[0]), frames[0]["configuration/box"].f32s());
    let mut counts = Vec::new();
    for (i, frame) in frames.iter().enumerate() {
        let state = states.read(i).unwrap();
        let n = state.bodies.len();
        counts.push(n);
        assert_eq!(frame["configuration/step"].u64s(), [state.step]);
        assert_eq!(frame["log/time"].f64s(), [state.time]);
        assert_eq!(frame["particles/N"].u32s(), [n as u32]);
        assert_eq!(frame["configuration/box"].f32s(), sides);
        assert_eq!(frame.contains_key("particles/types"), i == 0);
        for (name, columns) in [("position", 3), ("orientation", 4), ("velocity", 3), ("typeid", 1)] {
            let chunk = &frame[&format!("particles/{name}")];
            assert_eq!((chunk.rows, chunk.columns), (n, columns));
        }
        for (shape, of) in state.bodies.shape.iter().zip(frame["particles/typeid"].u32s()) {
            assert!(draws(&drawn[of as usize], shape, 1e-15));
        }
    }
    assert!(counts.is_sorted() && counts[0] == 1 && counts[25] == 8, "{counts:?}");
}

#[test]
fn many_sizes_are_classes_and_exact_besides() {
    let folder = tempfile::tempdir().unwrap();
    let state = many_rods(3000);
    let (path, done) = written(&folder, &States::single("rods", state.clone()));
    assert!(done.notes.iter().any(|note| note.contains("256 classes")), "{:?}", done.notes);
    let frame = &read(&path)[0];
    let (drawn, typeid) = (shapes(frame), frame["particles/typeid"].u32s());
    assert_eq!(drawn.len(), 256);
    let own = frame["log/particles/Aspherical Shape"].f32s();
    for (i, shape) in state.bodies.shape.iter().enumerate() {
        // Half a class is 1/256 of the length, and half of that at each end.
        assert!(draws(&drawn[typeid[i] as usize], shape, 1.0 / 512.0));
        let length = shape.growing_length().unwrap();
        assert_eq!(own[3 * i..3 * i + 3], [0.25, 0.0, (length - 0.5) as f32]);
    }
    assert_eq!(frame["particles/types"].texts()[255], "spherocylinder_255");
    assert_eq!(drawn[0]["type"], json!("ConvexPolyhedron"));
}

#[test]
fn no_bodies_are_a_frame_without_any() {
    let folder = tempfile::tempdir().unwrap();
    let empty = Snapshot { bodies: relcp::bodies::Bodies::default(), ..every_shape() };
    let (path, done) = written(&folder, &States::single("empty", empty));
    assert_eq!((done.states, done.bodies), (1, 0));
    let frame = &read(&path)[0];
    assert_eq!(frame["particles/N"].u32s(), [0]);
    assert!(!frame.contains_key("particles/position"));
}

#[test]
fn what_32_bits_cannot_hold_is_refused_with_its_place() {
    type Change = fn(&mut Snapshot);
    let changes: [(&str, Change); 5] = [
        ("position of 1e39", |s| s.bodies.position[7].y = 1e39),
        ("position of NaN", |s| s.bodies.position[7].y = f64::NAN),
        ("velocity of -inf", |s| s.bodies.velocity[7].z = f64::NEG_INFINITY),
        ("size of 1e50", |s| s.bodies.shape[7] = Shape::Sphere { radius: 1e50 }),
        ("size of 1e-50", |s| s.bodies.shape[7] = Shape::Sphere { radius: 1e-50 }),
    ];
    for (what, change) in changes {
        let folder = tempfile::tempdir().unwrap();
        let mut state = every_shape();
        change(&mut state);
        let path = folder.path().join("out.gsd");
        let error = gsd(&States::single("mine", state), &path, &mut |_, _| true).unwrap_err();
        assert!(matches!(error, ExportError::Unfit { body: 7, .. }));
        assert!(error.to_string().contains("mine: body 7") && error.to_string().contains(what), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn one_that_is_stopped_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.gsd");
    let mut calls = 0;
    let mut watch = |done: usize, all: usize| {
        calls += 1;
        assert_eq!(all, 2);
        done < 1
    };
    let error = gsd(&States::single("mine", every_shape()), &path, &mut watch).unwrap_err();
    assert!(matches!(error, ExportError::Stopped { done: 0, all: 1 }));
    assert_eq!(error.to_string(), "stopped after 0 of 1 states");
    assert_eq!(calls, 2);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
