//! Contact forces of bodies at rest, against what they bear.

use crate::scenes::{laws, parse};
use relcp::Simulation;
use relcp::scene::Scene;
use serde_json::{Value, json};

/// Balls of diameter 1 in a column, under an acceleration of 1.
const BALLS: usize = 8;
const WEIGHT: f64 = std::f64::consts::FRAC_PI_6;

fn column(law: &Value, dt: f64) -> Scene {
    let ball = |i: usize| json!({"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, 0.5 + i as f64]});
    parse(&json!({"name": "column", "time": {"dt": dt, "end": 200.0 * dt}, "dynamics": law,
        "forces": [{"uniform": {"force": [0, 0, -WEIGHT]}}],
        "walls": [{"half_space": {"normal": [0, 0, 1], "offset": 0}}],
        "bodies": (0..BALLS).map(ball).collect::<Vec<_>>()}))
}

/// The forces that balls 0, 1, ... are pushed up by at the end of the last steps: the largest error, in weights.
fn error(scene: Scene) -> f64 {
    let mut simulation = Simulation::new(scene).unwrap();
    let mut worst = 0.0_f64;
    while !simulation.done() {
        let step = simulation.step().unwrap().step;
        let mut below = [0.0; BALLS];
        for warm in &simulation.state().unwrap().warm {
            // A surface of a wall has a number beyond all bodies.
            let upper = if warm.pair[1] as usize >= BALLS { 0 } else { warm.pair[1] as usize };
            below[upper] += warm.gamma;
        }
        let off = |i: usize| (below[i] / WEIGHT - (BALLS - i) as f64).abs();
        if step > 50 {
            worst = (0..BALLS).map(off).fold(worst, f64::max);
        }
    }
    worst
}

#[test]
fn a_column_at_rest_bears_its_weight_at_any_step() {
    for law in laws() {
        for dt in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
            let off = error(column(&law, dt));
            println!("{law}, dt {dt:e}: {off:.1e} weights");
            assert!(off < 0.05, "{law}, dt {dt:e}: {off:e}");
        }
    }
}

#[test]
fn a_tolerance_that_a_scene_gives_is_kept() {
    let mut scene = column(&laws()[1], 1e-3);
    assert!(scene.lcp_settings().tolerance < 3e-9, "{}", scene.lcp_settings().tolerance);
    scene.solver.tolerance = Some(1e-6);
    assert_eq!(scene.lcp_settings().tolerance, 1e-6);
    // What moves bodies far in a step, or nothing at all, leaves the default at a tenth of the overlap tolerance.
    let mut long = column(&laws()[0], 1e-1);
    assert_eq!(long.lcp_settings().tolerance, 0.1 * long.contact.overlap_tolerance);
    long.forces.clear();
    assert_eq!(long.lcp_settings().tolerance, 0.1 * long.contact.overlap_tolerance);
}
