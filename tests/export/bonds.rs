//! Bonds in the formats that have them.

use crate::gsd_file::read;
use crate::vtp_file::{Vtp, collection};
use relcp::Scene;
use relcp::export::{Format, export};
use relcp::record::{Snapshot, States};
use relcp::simulation::Simulation;
use serde_json::json;
use std::fs;

/// Three balls that hang from each other, before a step and at rest.
fn hanging() -> [Snapshot; 2] {
    let ball = |i: i32| json!({"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, -1.5 * f64::from(i)], "fixed": i == 0});
    let bond = |i: usize| json!({"bodies": [i + 1, i], "at": [[0, 0, 0.5], [0, 0, -0.5]], "length": 0.5, "stiffness": "rigid"});
    let scene = json!({"name": "hanging", "time": {"dt": 0.05, "end": 0.5}, "dynamics": {"overdamped": {"drag": 1.0}},
        "forces": [{"uniform": {"force": [0, 0, -1]}}], "bodies": (0..3).map(ball).collect::<Vec<_>>(),
        "bonds": [bond(0), bond(1)]});
    let scene = Scene::parse(&scene.to_string(), "hanging").unwrap();
    let mut simulation = Simulation::new(scene).unwrap();
    let shot = |simulation: &Simulation| {
        let state = simulation.state().unwrap();
        let (step, time, bodies) = (state.step, simulation.time(), state.bodies.clone());
        Snapshot { step, time, bodies, warm: None, removed: Vec::new(), fields: Vec::new() }
    };
    let first = shot(&simulation);
    while !simulation.done() {
        simulation.step().unwrap();
    }
    [first, shot(&simulation)]
}

#[test]
fn lammps_and_gsd_have_the_bonds_and_their_forces() {
    let [_, last] = hanging();
    let out = tempfile::tempdir().unwrap();
    let states = States::single("hanging", last);
    let done = export(&states, Format::Lammps, out.path(), &mut |_, _| true).unwrap();
    assert_eq!(done.files.len(), 2);
    assert!(done.files[1].ends_with("hanging.bonds.lammpstrj"));
    let text = fs::read_to_string(&done.files[1]).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[4..6], ["ITEM: NUMBER OF ENTRIES", "2"]);
    assert_eq!(lines[10], "ITEM: ENTRIES index batom1 batom2 btype dist tension fx fy fz");
    for (k, line) in lines[11..].iter().enumerate() {
        let words: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        let tension = (2 - k) as f64;
        assert_eq!(words[..4], [k as f64 + 1.0, k as f64 + 2.0, k as f64 + 1.0, 1.0]);
        assert!((words[4] - 0.5).abs() < 1e-4 && (words[5] - tension).abs() < 1e-2, "{line}");
        // The second body is the upper one, which is pulled down.
        assert!((words[8] + tension).abs() < 1e-2 && words[6].abs() < 1e-6, "{line}");
    }
    let done = export(&states, Format::Gsd, out.path(), &mut |_, _| true).unwrap();
    let frame = &read(&done.files[0])[0];
    assert_eq!(frame["bonds/N"].u32s(), [2]);
    assert_eq!(frame["bonds/types"].texts(), ["bond"]);
    assert_eq!(frame["bonds/typeid"].u32s(), [0, 0]);
    assert_eq!(frame["bonds/group"].u32s(), [1, 0, 2, 1]);
    assert!((frame["log/bonds/force"].f64s()[2] + 2.0).abs() < 1e-2);
}

#[test]
fn paraview_has_a_line_a_bond() {
    let [first, last] = hanging();
    for (state, force) in [(first, 0.0), (last, 2.0)] {
        let out = tempfile::tempdir().unwrap();
        export(&States::single("hanging", state), Format::Vtk { cutoff: None }, out.path(), &mut |_, _| true).unwrap();
        let vtp = Vtp::read(&collection(&out.path().join("bonds.pvd"))[0].1);
        assert_eq!((vtp.counts["NumberOfLines"], vtp.points()), (2, 4));
        assert_eq!(vtp.cells("Lines"), [vec![0, 1], vec![2, 3]]);
        let tensions = vtp.rows("CellData", "tension");
        assert!((tensions[0][0] - force).abs() < 1e-2, "{tensions:?}");
        assert_eq!(vtp.rows("CellData", "a"), [[1.0], [2.0]]);
    }
}
