//! Self-propelled rods: from ballistic to diffusive motion, and against a wall.

use crate::scenes::parse;
use glam::DVec3;
use relcp::simulation::Simulation;
use serde_json::{Value, json};

const KT: f64 = 0.3;
const LENGTH: f64 = 1.5;
const FORCE: f64 = 3.0;
/// Rods of a sample.
const SAMPLE: usize = 600;

/// Swimmers too far from each other to meet, drag 1.
fn swimmers(planar: bool, (dt, end): (f64, f64)) -> Value {
    let body = |i: usize| {
        let place = [200.0 * (i % 25) as f64, 200.0 * (i / 25) as f64, 0.0];
        json!({"shape": {"spherocylinder": {"diameter": 0.4, "length": LENGTH}}, "position": place, "axis": [1, 0.3, 0]})
    };
    json!({"name": "swimmers", "seed": 4, "planar": planar, "time": {"dt": dt, "end": end},
        "dynamics": {"overdamped": {"drag": 1}}, "thermal": {"temperature": KT},
        "forces": [{"propulsion": {"force": FORCE}}], "bodies": (0..SAMPLE).map(body).collect::<Vec<_>>()})
}

/// `2 d D t + 2 v^2 tau^2 (t / tau - 1 + e^(-t / tau))` in `d` dimensions, with `tau = 1 / (d - 1) D_r` (for discs J.
/// R. Howse et al., Phys. Rev. Lett. 99, 048102 (2007)). The turn of a step's map makes `D_r` smaller by the part `5/3
/// D_r dt`, in the plane `D_r dt`.
fn crossover(planar: bool, dt: f64, t: f64) -> f64 {
    let (d, lost) = if planar { (2.0, 1.0) } else { (3.0, 5.0 / 3.0) };
    let (diffusion, turning, speed) = (KT / LENGTH, 12.0 * KT / LENGTH.powi(3), FORCE / LENGTH);
    let tau = 1.0 / ((d - 1.0) * turning * (1.0 - lost * turning * dt));
    2.0 * d * diffusion * t + 2.0 * (speed * tau).powi(2) * (t / tau - 1.0 + (-t / tau).exp())
}

#[test]
fn a_swimmer_goes_from_ballistic_to_diffusive_motion_by_the_closed_form() {
    for planar in [true, false] {
        let dt = 0.005;
        let mut simulation = Simulation::new(parse(&swimmers(planar, (dt, 6.0)))).unwrap();
        let start = simulation.state().unwrap().bodies.position.clone();
        for t in [0.05, 0.5, 1.5, 6.0] {
            while simulation.time() < t - 0.5 * dt {
                simulation.step().unwrap();
            }
            let end = &simulation.state().unwrap().bodies.position;
            let squares: Vec<f64> = end.iter().zip(&start).map(|(a, b)| a.distance_squared(*b)).collect();
            let n = SAMPLE as f64;
            let mean = squares.iter().sum::<f64>() / n;
            let error = (squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
            let expected = crossover(planar, dt, t);
            let errors = (mean - expected) / error;
            println!("planar {planar}, t {t}: {mean:.4}, closed form {expected:.4}, {errors:+.2} standard errors");
            assert!(errors.abs() < 3.0, "planar {planar}, t {t}: {mean} {expected}");
        }
    }
}

/// A rod that swims into a wall pushes it with its force, and lies along it or stands on it within the tolerance.
#[test]
fn a_swimmer_at_a_wall_stays_within_the_tolerance_and_pushes_with_its_force() {
    for (stepping, axis, planar) in
        [("euler", [1.0, 0.0, 0.0], true), ("midpoint", [1.0, 0.4, 0.0], true), ("euler", [1.0, 0.4, 0.2], false)]
    {
        let mut simulation = Simulation::new(parse(&json!({"name": "wall", "planar": planar,
            "time": {"dt": 0.01, "end": 8, "stepping": stepping}, "forces": [{"propulsion": {"force": FORCE}}],
            "walls": [{"half_space": {"normal": [-1, 0, 0], "offset": -3}}],
            "bodies": [{"shape": {"spherocylinder": {"diameter": 0.4, "length": LENGTH}}, "position": [0, 0, 0], "axis": axis}]})))
        .unwrap();
        while !simulation.done() {
            assert!(simulation.step().unwrap().max_overlap <= 1e-5);
        }
        let state = simulation.state().unwrap();
        if axis[1] == 0.0 {
            let pushed: f64 = state.warm.iter().map(|w| w.gamma).sum();
            assert!((pushed - FORCE).abs() < 1e-4 * FORCE, "{pushed}");
            assert!((state.bodies.position[0].x - (3.0 - 0.5 * LENGTH)).abs() < 2e-5);
        } else {
            // It has turned along the wall and swims there.
            let along = state.bodies.orientation[0] * DVec3::Z;
            assert!(along.x.abs() < 1e-2 && along.y > 0.8, "{along}");
            assert!((state.bodies.position[0].x - 2.8).abs() < 1e-2, "{}", state.bodies.position[0]);
        }
    }
}
