//! What a periodic run leaves, and what the program makes of it.

use crate::{audit, suspension};
use glam::DVec3;
use relcp::Scene;
use relcp::bodies::Bodies;
use relcp::measure::{Settings, measure, select};
use relcp::periodic::Periods;
use relcp::record::{Snapshot, StateError, States, contacts, decode, encode, encode_with_forces, read_state};
use relcp::separation::Placed;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use relcp::step::State;
use relcp::warm::Warm;
use serde_json::{Value, json};
use std::path::Path;

#[path = "../export/gsd_file.rs"]
#[allow(dead_code)]
mod gsd_file;

fn relcp(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let mut program = assert_cmd::Command::cargo_bin("relcp").unwrap();
    let output = program.current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_state_carries_its_periods_and_refuses_those_that_cannot_be() {
    let scene = suspension("rod");
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    simulation.step().unwrap();
    let state = simulation.state().unwrap();
    let bytes = encode_with_forces(state, "0123", 0.1).unwrap();
    let (header, read) = decode(&bytes).unwrap();
    assert_eq!((header.periodic, &read), (Some([Some(10.0), Some(9.0), Some(11.0)]), state));
    for wrong in [[Some(7.9), None, None], [Some(1e300), None, None]] {
        let mut state = state.clone();
        state.bodies.periods = relcp::periodic::Periods::new(wrong);
        let refused = decode(&encode(&state, "0123", 0.1, None).unwrap()).unwrap_err();
        assert!(matches!(refused, StateError::Damaged { .. }), "{refused}");
    }
    // Without periods the header says nothing of them.
    let mut open = state.clone();
    open.bodies.periods = relcp::periodic::Periods::NONE;
    let bytes = encode(&open, "0123", 0.1, None).unwrap();
    assert!(!String::from_utf8_lossy(&bytes).contains("periodic"));
}

#[test]
fn contacts_are_listed_at_every_image_that_is_near() {
    let text = r#"{ "name": "one", "time": { "dt": 0.1, "end": 1 }, "periodic": { "lengths": [5, 4, null] },
        "bodies": [ { "shape": { "sphere": { "radius": 0.5 } }, "position": [0, 0, 0] },
                    { "shape": { "sphere": { "radius": 0.5 } }, "position": [12.4, 0, 0] } ] }"#;
    let bodies = Scene::parse(text, "one").unwrap().build().unwrap();
    let found = |cutoff: f64| -> Vec<_> {
        let near = relcp::step::contacts(&bodies, cutoff).into_iter();
        near.map(|near| (near.bodies, near.image.to_array(), (near.separation * 1e9).round() / 1e9)).collect()
    };
    assert_eq!(found(1.3), []);
    assert_eq!(found(1.45), [([0, 1], [-2, 0, 0], 1.4)]);
    // Both images along x, and its own along y.
    assert_eq!(
        found(3.0),
        [([0, 0], [0, 1, 0], 3.0), ([0, 1], [-3, 0, 0], 1.6), ([0, 1], [-2, 0, 0], 1.4), ([1, 1], [0, 1, 0], 3.0)]
    );
    let at = relcp::step::contacts(&bodies, 1.45)[0];
    assert!((at.normal - DVec3::X).length() < 1e-15);
    // More than a period counts as one.
    assert_eq!(found(1e9), found(4.0));
}

#[test]
fn forces_balance_and_measures_know_the_cell() {
    let mut scene = suspension("ellipsoid");
    scene.output.forces = true;
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let state = simulation.state().unwrap();
    let snapshot = Snapshot {
        step: state.step,
        time: 3.0,
        bodies: state.bodies.clone(),
        warm: Some(state.warm.clone()),
        removed: Vec::new(),
        fields: Vec::new(),
    };
    // On each body contact and outer forces are those that its velocity takes, up to what normals turned since the rows
    // were made.
    let (mut force, mut pushing, mut through) = (vec![DVec3::ZERO; 30], 0, 0);
    for contact in contacts(&snapshot, None).iter().filter(|contact| contact.gamma > 0.0) {
        let [a, b] = contact.pair;
        force[a] -= contact.gamma * contact.normal;
        force[b] += contact.gamma * contact.normal;
        pushing += 1;
        through += usize::from(contact.shift != DVec3::ZERO);
        // The point is at both surfaces, up to half of the gap.
        let reach = state.bodies.shape[b].bounding_radius() + 0.1;
        assert!(contact.point.distance(state.bodies.position[a]) < reach);
        assert!(contact.point.distance(state.bodies.position[b] + contact.shift) < reach);
    }
    println!("{pushing} push, {through} through a boundary");
    assert!(through >= 3 && pushing > through);
    let mut off = Vec::new();
    for (i, contact) in force.into_iter().enumerate() {
        let outer = if i < 15 { DVec3::new(3.0, 1.0, 0.0) } else { DVec3::new(-3.0, 0.5, 0.0) };
        let drag = state.bodies.velocity[i] * state.bodies.shape[i].major_axis();
        off.push((outer + contact - drag).length());
    }
    off.sort_by(f64::total_cmp);
    println!("forces are off by {:.3} at the median, {:.3} at most, of 3", off[15], off[29]);
    assert!(off[15] < 0.02 && off[29] < 0.15, "{off:?}");
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("state.npz");
    std::fs::write(&file, encode_with_forces(state, "0123", 3.0).unwrap()).unwrap();
    let measured = |file: &Path| {
        let source = file.to_str().unwrap();
        measure(source, &States::open(source).unwrap(), &select(&[]).unwrap(), &Settings::default(), &mut |_, _| true)
            .unwrap()
    };
    let found = measured(&file);
    let volume: f64 = state.bodies.shape.iter().map(|shape| shape.volume()).sum();
    assert!((found.value(0, "packing_cell").unwrap() - volume / (9.5 * 10.0 * 10.5)).abs() < 1e-12);
    for none in ["radius_outermost", "density_bin", "packing_core"] {
        assert_eq!(found.value(0, none), None, "{none}");
    }
    assert!(found.notes.iter().any(|note| note.contains("density: a periodic scene")), "{:?}", found.notes);
    // Nothing that is measured depends on the images that bodies are at.
    let mut moved = state.clone();
    let length = state.bodies.periods.length();
    moved.bodies.position.iter_mut().step_by(3).for_each(|x| *x += length * DVec3::new(1.0, -2.0, 5.0));
    let other = place.path().join("moved.npz");
    std::fs::write(&other, encode_with_forces(&moved, "0123", 3.0).unwrap()).unwrap();
    let again = measured(&other);
    let mut compared = 0;
    for ((column, one), other) in found.columns().zip(found.values(0)).zip(again.values(0)) {
        assert_eq!(one.is_some(), other.is_some(), "{}", column.name);
        if let (Some(one), Some(other)) = (one, other) {
            assert!((one - other).abs() <= 1e-7 * one.abs().max(1.0), "{}: {one} {other}", column.name);
            compared += 1;
        }
    }
    assert!(compared > 25, "{compared}");
}

/// A cubic lattice of touching spheres that fills its cell, with the same force in each contact: the stress is known.
#[test]
fn a_lattice_without_a_boundary_has_its_stress() {
    let at = |k: u32| [k % 3, k / 3 % 3, k / 9];
    let mut bodies = Bodies { periods: Periods::new([Some(3.0); 3]), ..Bodies::default() };
    for k in 0..27 {
        let position = DVec3::from(at(k).map(f64::from)) + 3.0 * f64::from(k % 5);
        bodies.push(Placed { shape: Shape::Sphere { radius: 0.5 }, position, orientation: glam::DQuat::IDENTITY }, 0);
    }
    let mut warm = Vec::new();
    for k in 0..27 {
        for axis in 0..3 {
            let mut next = at(k);
            next[axis] = (next[axis] + 1) % 3;
            let other = next[0] + 3 * next[1] + 9 * next[2];
            let pair = [k.min(other), k.max(other)];
            warm.push(Warm {
                pair,
                feature: 0,
                gamma: [2.0, 3.0, 4.0][axis],
                normal: DVec3::ZERO,
                tangent: DVec3::ZERO,
            });
        }
    }
    warm.sort_by_key(|warm| warm.pair);
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("lattice.npz");
    let state = State { step: 1, next_id: 27, bodies, warm, ..State::default() };
    std::fs::write(&file, encode_with_forces(&state, "0123", 1.0).unwrap()).unwrap();
    let source = file.to_str().unwrap();
    let measures = select(&["stress".into(), "contacts".into(), "packing".into()]).unwrap();
    let settings = Settings::default();
    let found = measure(source, &States::open(source).unwrap(), &measures, &settings, &mut |_, _| true).unwrap();
    let value = |column: &str| found.value(0, column).unwrap();
    let volume = std::f64::consts::PI / 6.0;
    for (column, expected) in [
        ("stress_xx", 2.0 / volume),
        ("stress_yy", 3.0 / volume),
        ("stress_zz", 4.0 / volume),
        ("pressure", 3.0 / volume),
        ("touching_per_body", 6.0),
        ("pushing_per_body", 6.0),
        ("packing_cell", volume),
    ] {
        assert!((value(column) - expected).abs() < 1e-12, "{column}: {} {expected}", value(column));
    }
    assert!(value("stress_xy").abs() < 1e-12);
}

#[test]
fn the_program_runs_resumes_exports_and_draws_a_periodic_scene() {
    let place = tempfile::tempdir().unwrap();
    let mut scene = suspension("rod");
    scene.time.end = 2.0;
    scene.output.every = Some(1.0);
    std::fs::write(place.path().join("scene.json"), scene.to_json()).unwrap();
    let read =
        |path: &str| -> Value { serde_json::from_slice(&std::fs::read(place.path().join(path)).unwrap()).unwrap() };
    for (threads, out) in [("1", "one"), ("3", "three")] {
        let (status, _, error) = relcp(
            place.path(),
            &["run", "scene.json", "--out", out, "--threads", threads, "--backend", "cpu", "--quiet"],
        );
        assert_eq!(status, 0, "{error}");
    }
    let summary = read("one/summary.json");
    assert_eq!(read("three/summary.json")["state_hash"], summary["state_hash"]);
    assert!(summary["max_overlap"].as_f64().unwrap() <= 1e-5);
    let bodies = read_state(&place.path().join("one/checkpoint.npz")).unwrap().1.bodies;
    let audited = audit(&bodies);
    assert!((audited - summary["final_max_overlap"].as_f64().unwrap()).abs() < 1e-13, "{audited} {summary}");
    // From the final state, from the checkpoint, and from a state.
    for state in ["one", "one/final.json", "one/states/state_0000000040.npz"] {
        let (status, out, error) = relcp(place.path(), &["contacts", state, "--json", "--cutoff", "0.01"]);
        assert_eq!(status, 0, "{error}");
        let report: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(report["max_overlap"], summary["final_max_overlap"], "{state}");
        let point = |value: &Value| DVec3::from([0, 1, 2].map(|i| value[i].as_f64().unwrap()));
        let found = report["contacts"].as_array().unwrap();
        assert!(found.iter().any(|contact| contact["image"] != json!([0, 0, 0])) && found.len() >= 3);
        for contact in found {
            let apart = point(&contact["normal"]).dot(point(&contact["point_b"]) - point(&contact["point_a"]));
            assert!((apart - contact["separation"].as_f64().unwrap()).abs() < 1e-12, "{contact}");
        }
    }
    let (status, _, error) = relcp(place.path(), &["export", "one", "--format", "gsd", "--quiet"]);
    assert_eq!(status, 0, "{error}");
    let frames = gsd_file::read(&place.path().join("one/gsd/one.gsd"));
    let last = &frames[frames.len() - 1];
    assert_eq!(last["configuration/box"].f32s(), [10.0, 9.0, 11.0, 0.0, 0.0, 0.0]);
    let (position, image) = (last["particles/position"].f32s(), last["particles/image"].i32s());
    let length = bodies.periods.length();
    for i in 0..30 {
        let wrapped = DVec3::from([0, 1, 2].map(|k| f64::from(position[3 * i + k])));
        let away = DVec3::from([0, 1, 2].map(|k| f64::from(image[3 * i + k])));
        assert!(wrapped.abs().cmple(0.5 * length + 1e-6).all());
        assert!((wrapped + away * length - bodies.position[i]).length() < 1e-5);
    }
    assert!(image.iter().any(|n| *n != 0), "some body has left the cell");
    for arguments in
        [&["export", "one", "--format", "vtk", "--quiet"][..], &["render", "one", "--size", "160x120", "--quiet"]]
    {
        let (status, _, error) = relcp(place.path(), arguments);
        assert_eq!(status, 0, "{arguments:?}: {error}");
    }
    let bodies_file = std::fs::read(place.path().join("one/vtk/states/bodies_0000000040.vtp")).unwrap();
    assert!(String::from_utf8_lossy(&bodies_file).contains("Name=\"image\""));
    let (status, _, error) = relcp(place.path(), &["run", "scene.json", "--out", "device", "--backend", "gpu"]);
    assert!(status == 0 || status == 5 && error.contains("adapter"), "{status} {error}");
    let (status, _, error) = relcp(
        place.path(),
        &["run", "one/final.json", "--set", "time.end=2.5", "--out", "on", "--backend", "cpu", "--quiet"],
    );
    assert_eq!(status, 0, "{error}");
    // A period of another length is another scene.
    let (status, _, error) = relcp(
        place.path(),
        &["run", "scene.json", "--set", "periodic.lengths.0=10.1", "--out", "one", "--resume", "--backend", "cpu"],
    );
    assert!(status != 0 && error.contains("periodic"), "{status} {error}");
}

/// Exports of a sheared cell have its tilt, and bodies in the tilted box; measures and pictures know it.
#[test]
fn the_program_exports_and_measures_a_sheared_scene() {
    let place = tempfile::tempdir().unwrap();
    let text = r#"{"name": "sheared", "seed": 3, "time": {"dt": 0.02, "end": 0.8}, "output": {"every": 0.4, "forces": true},
        "periodic": {"lengths": [9, 10, 11], "shear": {"rate": 0.9, "direction": "y", "gradient": "z"}},
        "generate": [{"isotropic": {"count": 60, "shape": {"sphere": {"radius": 1.0}}}}],
        "dynamics": {"overdamped": {"drag": 1}}}"#;
    std::fs::write(place.path().join("scene.json"), text).unwrap();
    for arguments in [
        &["run", "scene.json", "--out", "one", "--backend", "cpu", "--quiet"][..],
        &["export", "one", "--format", "gsd", "--quiet"],
        &["export", "one", "--format", "lammps", "--quiet"],
        &["export", "one", "--format", "xyz", "--quiet"],
        &["export", "one", "--format", "vtk", "--quiet"],
        &["render", "one", "--size", "160x120", "--quiet"],
        &["view", "one", "--quiet"],
        &["measure", "one", "--only", "shear_stress,stress"],
    ] {
        let (status, _, error) = relcp(place.path(), arguments);
        assert_eq!(status, 0, "{arguments:?}: {error}");
    }
    let bodies = read_state(&place.path().join("one/checkpoint.npz")).unwrap().1.bodies;
    // 0.9 times 0.8 times 11, less a period along y.
    let offset = 0.9 * 0.8 * 11.0 - 10.0;
    let tilt = bodies.periods.tilt().unwrap();
    assert!((tilt.offset - offset).abs() < 1e-12, "{tilt:?}");
    let frames = gsd_file::read(&place.path().join("one/gsd/one.gsd"));
    let last = &frames[frames.len() - 1];
    let cell = last["configuration/box"].f32s();
    assert_eq!(cell[..5], [9.0, 10.0, 11.0, 0.0, 0.0]);
    assert!((f64::from(cell[5]) - offset / 11.0).abs() < 1e-6, "{cell:?}");
    let (position, image) = (last["particles/position"].f32s(), last["particles/image"].i32s());
    for (i, unwrapped) in bodies.position.iter().enumerate() {
        let wrapped = DVec3::from([0, 1, 2].map(|k| f64::from(position[3 * i + k])));
        let n = DVec3::from([0, 1, 2].map(|k| f64::from(image[3 * i + k])));
        let edges =
            n.x * DVec3::new(9.0, 0.0, 0.0) + n.y * DVec3::new(0.0, 10.0, 0.0) + n.z * DVec3::new(0.0, offset, 11.0);
        assert!((wrapped + edges - *unwrapped).length() < 1e-5);
        let part = DVec3::new(wrapped.x / 9.0, (wrapped.y - offset * wrapped.z / 11.0) / 10.0, wrapped.z / 11.0);
        assert!(part.abs().max_element() < 0.5 + 1e-6, "{part}");
    }
    let file = |path: &str| std::fs::read_to_string(place.path().join(path)).unwrap();
    let found = |name: &str| -> std::path::PathBuf {
        let all = walk(&place.path().join("one"));
        all.into_iter().find(|path| path.to_string_lossy().ends_with(name)).unwrap()
    };
    let dump = std::fs::read_to_string(found(".lammpstrj")).unwrap();
    let head = dump.rsplit("ITEM: BOX BOUNDS ").next().unwrap();
    let lines: Vec<&str> = head.lines().collect();
    assert_eq!(lines[0], "xy xz yz pp pp pp");
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').map(|x| x.parse().unwrap()).collect() };
    let expected = [[-4.5, 4.5, 0.0], [-5.0 + 0.5 * offset, 5.0 - 0.5 * offset, 0.0], [-5.5, 5.5, offset]];
    for (line, expected) in lines[1..4].iter().zip(expected) {
        assert!(numbers(line).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{line}, {expected:?}");
    }
    let xyz = std::fs::read_to_string(found(".xyz")).unwrap();
    assert!(xyz.contains("Lattice=\"9.0 0 0 0.0 10.0 0 0.0 -2.0799"), "{}", xyz.lines().nth(1).unwrap());
    let measures = file("one/measures/measures.csv");
    let header: Vec<&str> = measures.lines().next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let last: Vec<f64> = measures.lines().last().unwrap().split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect();
    // The same sum over another volume.
    let share = 60.0 * 4.0 / 3.0 * std::f64::consts::PI / 990.0;
    let (ours, theirs) = (last[column("shear_stress")], -share * last[column("stress_yz")]);
    assert!(ours > 0.0 && (ours / theirs - 1.0).abs() < 1e-10, "{ours} {theirs}");
    assert!((last[column("shear_strain")] - 0.72).abs() < 1e-12);
}

fn walk(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path] }).collect()
}
