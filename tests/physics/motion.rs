//! Measures of motion against theory.

use crate::scenes::parse;
use relcp::measure::{Frame, Settings, Tracks, View, select};
use relcp::record::Snapshot;
use relcp::simulation::{Compute, Simulation};
use serde_json::json;

/// Temperature, drag, step and number of steps.
const KT: f64 = 0.7;
const DRAG: f64 = 1.2;
const DT: f64 = 0.003;
const STEPS: usize = 16;

/// Free bodies diffuse: the measure's own standard errors cover what theory says.
#[test]
fn free_brownian_bodies_have_the_msd_of_theory() {
    for planar in [false, true] {
        let place = |i: usize| [20.0 * (i % 25) as f64, 20.0 * (i / 25) as f64, 0.0];
        let body = |i: usize| json!({"shape": {"spherocylinder": {"diameter": 0.25, "length": 1.25}}, "position": place(i), "axis": [1, 0, 0]});
        let scene =
            parse(&json!({"name": "free", "seed": 5, "planar": planar, "time": {"dt": DT, "end": DT * STEPS as f64},
            "dynamics": {"overdamped": {"drag": DRAG}}, "thermal": {"temperature": KT},
            "bodies": (0..500).map(body).collect::<Vec<_>>()}));
        let frame = Frame::of_scene(&scene, "test".into());
        let mut simulation = Simulation::builder(scene).on(&Compute::Cpu).build().unwrap();
        let (mut tracks, mut times, mut found) = (Tracks::new(STEPS + 1, 1), Vec::new(), Vec::new());
        let measure = select(&["msd".into()]).unwrap()[0];
        loop {
            let state = simulation.state().unwrap();
            tracks.push(&state.bodies, &Default::default());
            let (step, bodies) = (state.step, state.bodies.clone());
            let snapshot =
                Snapshot { step, time: simulation.time(), bodies, warm: None, removed: Vec::new(), fields: Vec::new() };
            found.push(measure.of(&View::new(&snapshot, &frame, &Settings::default())));
            times.push(snapshot.time);
            if simulation.done() {
                break;
            }
            simulation.step().unwrap();
        }
        measure.along(&times, &tracks, &mut found);
        let rows = &found[STEPS].as_ref().unwrap().rows;
        assert_eq!(rows.len(), STEPS);
        let (moves, turns) = if planar { (2.0, 1.0) } else { (3.0, 3.0) };
        let (diffusion, turning) = (KT / (DRAG * 1.25), 12.0 * KT / (DRAG * 1.25_f64.powi(3)));
        // What the map of a step leaves out of a turn.
        let map = 1.0 - turning * DT * if planar { 1.0 } else { 5.0 / 3.0 };
        for k in [1, 4, 16] {
            // At the start no body has a velocity, and so no direction.
            let row: Vec<f64> = rows[k - 1].iter().map(|cell| cell.unwrap_or(f64::NAN)).collect();
            let lag = DT * k as f64;
            assert!((row[0] - lag).abs() < 1e-12 && row[7] == (500 * (STEPS + 1 - k)) as f64);
            for (name, at, expected) in
                [("msd", 1, 2.0 * moves * diffusion * lag), ("msr", 3, 2.0 * turns * turning * lag * map)]
            {
                let errors = (row[at] - expected) / row[at + 1];
                println!(
                    "{name}, planar {planar}, {k} steps: {} over {expected}, {errors:+.2} standard errors",
                    row[at]
                );
                assert!(errors.abs() < 3.0 && row[at + 1] < 0.1 * expected, "{name} {row:?}");
            }
        }
    }
}
