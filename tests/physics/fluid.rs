//! A fluid of hard rods in the plane: its pressure against a published equation of state.

use crate::scenes::parse;
use relcp::simulation::Simulation;
use serde_json::json;
use std::f64::consts::PI;

const RODS: usize = 64;
/// Rods of aspect ratio 3 cover this part of the plane: the fluid is isotropic.
const COVERED: f64 = 0.3;

/// `p / (rho kT)` of a convex body's fluid by T. Boublik's equation for the plane, with `gamma` from its perimeter and
/// area: the scaled particle theory's, and a term that mends its third virial coefficient.
fn boublik(covered: f64, gamma: f64) -> f64 {
    let mended = 1.0 + gamma * (covered / 7.0 - covered * covered / 14.0);
    1.0 / (1.0 - covered) + gamma * covered * mended / (1.0 - covered).powi(2)
}

/// Mean and standard error of `p / (rho kT)`, from blocks of time: 1 for the rods as an ideal gas, and the virial of
/// the contact forces.
fn measured(dt: f64, end: f64) -> (f64, f64) {
    let area = RODS as f64 * (2.0 + PI / 4.0) / COVERED;
    let side = area.sqrt();
    let scene = parse(&json!({"name": "fluid", "seed": 3, "planar": true, "time": {"dt": dt, "end": end},
        "dynamics": {"overdamped": {"drag": 1}}, "thermal": {"temperature": 1},
        "periodic": {"lengths": [side, side, null]},
        "generate": [{"isotropic": {"count": RODS, "shape": {"spherocylinder": {"diameter": 1, "length": 3}}}}]}));
    let mut simulation = Simulation::new(scene).unwrap();
    let mut blocks: Vec<(f64, f64)> = vec![(0.0, 0.0); 16];
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
        // A twentieth to settle: the time in which a rod diffuses by its length is some 4.
        let share = simulation.time() / end * 1.05 - 0.05;
        if share <= 0.0 {
            continue;
        }
        let state = simulation.state().unwrap();
        let virial = |w: &relcp::warm::Warm| {
            let [a, b] = w.pair.map(|body| state.bodies.position[body as usize]);
            w.gamma * w.normal.dot(state.bodies.periods.nearest(b - a))
        };
        let block = &mut blocks[((16.0 * share) as usize).min(15)];
        *block = (block.0 + state.warm.iter().map(virial).sum::<f64>(), block.1 + 1.0);
    }
    let of_block = |(sum, count): &(f64, f64)| 1.0 + sum / count / (2.0 * RODS as f64);
    let blocks: Vec<f64> = blocks.iter().map(of_block).collect();
    let mean = blocks.iter().sum::<f64>() / 16.0;
    let variance = blocks.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / 15.0;
    (mean, (variance / 16.0).sqrt())
}

/// A step is of the order of `sqrt(dt)` beside a contact, so that two step sizes, one a quarter of the other, are
/// extrapolated to none.
#[test]
fn the_pressure_of_a_fluid_of_hard_rods_is_that_of_the_equation_of_state() {
    let (coarse, fine) = (measured(0.008, 60.0), measured(0.002, 60.0));
    let (z, error) = (2.0 * fine.0 - coarse.0, (4.0 * fine.1.powi(2) + coarse.1.powi(2)).sqrt());
    let gamma = (4.0 + PI).powi(2) / (4.0 * PI * (2.0 + PI / 4.0));
    let expected = boublik(COVERED, gamma);
    println!("{coarse:.3?}, {fine:.3?}: {z:.3} +- {error:.3}, by the equation {expected:.3}");
    assert!((z - expected).abs() < 3.0 * error && error < 0.1, "{z} {error} {expected}");
}
