//! Chains in heat against the closed forms of their end-to-end distances, bond lengths and directions, with what the
//! scheme's steps make of them.
//!
//! An implicit Euler step makes `x (1 - a) + noise` of a mode that relaxes by the part `a` in it into `(x + noise) / (1 +
//! a)`, so that its variance is the part `1 / (1 + a / 2)` of that in equilibrium: the bias of the scheme.

use crate::scenes::parse;
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::simulation::Simulation;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// The mean over all chains, and its standard error: chains are independent of each other.
fn mean_and_error(of_chains: &[f64]) -> (f64, f64) {
    let count = of_chains.len() as f64;
    let mean = of_chains.iter().sum::<f64>() / count;
    let squares: f64 = of_chains.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (squares / (count * (count - 1.0))).sqrt())
}

/// The mean of a value of each chain over a run, after so many steps.
fn means(of: &Value, (chains, skipped): (usize, u64), value: impl Fn(&Bodies, usize) -> Vec<f64>) -> Vec<Vec<f64>> {
    let mut simulation = Simulation::new(parse(of)).unwrap();
    let mut sums: Vec<Vec<f64>> = vec![Vec::new(); chains];
    let mut recursions = 0_u64;
    while !simulation.done() {
        recursions += u64::from(simulation.step().unwrap().recursions);
        if simulation.steps() <= skipped {
            continue;
        }
        let bodies = &simulation.state().unwrap().bodies;
        for (chain, sums) in sums.iter_mut().enumerate() {
            let values = value(bodies, chain);
            sums.resize(values.len(), 0.0);
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
    }
    println!("recursions a step: {:.1}", recursions as f64 / simulation.steps() as f64);
    let counted = (simulation.steps() - skipped) as f64;
    sums.into_iter().map(|sums| sums.into_iter().map(|sum| sum / counted).collect()).collect()
}

/// Checks that the means of all chains are right to three standard errors.
fn agrees(what: &str, means: &[Vec<f64>], expected: &[(&str, f64)]) {
    for (k, (name, expected)) in expected.iter().enumerate() {
        let (mean, error) = mean_and_error(&means.iter().map(|of| of[k]).collect::<Vec<_>>());
        println!("{what}, {name}: {mean:.4} +- {error:.4}, expected {expected:.4}");
        assert!((mean - expected).abs() < 3.0 * error, "{what}, {name}: {mean} +- {error}, not {expected}");
    }
}

const BEADS: usize = 8;
const STIFFNESS: f64 = 1.0;
const KT: f64 = 1.0;

/// Rouse's chains: small balls with springs of length 0, each with a drag of 1.
fn rouse(chains: usize, (dt, steps): (f64, u64)) -> Value {
    let radius = 0.01;
    let ball = |i: usize| {
        let [x, y] = [i / BEADS % 6, i / BEADS / 6].map(|of| 60.0 * of as f64);
        json!({"shape": {"sphere": {"radius": radius}}, "position": [x, y, 0.1 * (i % BEADS) as f64]})
    };
    let bond = |i: usize| {
        let first = i / (BEADS - 1) * BEADS + i % (BEADS - 1);
        json!({"bodies": [first, first + 1], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": STIFFNESS, "implicit": true})
    };
    json!({"name": "rouse", "seed": 7, "time": {"dt": dt, "end": dt * steps as f64},
        "dynamics": {"overdamped": {"drag": 1.0 / (2.0 * radius)}}, "thermal": {"temperature": KT},
        "bodies": (0..chains * BEADS).map(ball).collect::<Vec<_>>(),
        "bonds": (0..chains * (BEADS - 1)).map(bond).collect::<Vec<_>>()})
}

/// The mean squares of the distance of both ends and of a bond, by the sum over modes with the scheme's bias.
fn of_modes(dt: f64) -> [f64; 2] {
    let count = BEADS as f64;
    let mode = |p: usize| {
        let part = PI * p as f64 / count;
        let rate = 4.0 * (0.5 * part).sin().powi(2);
        let variance = 3.0 * KT / (STIFFNESS * rate) / (1.0 + 0.5 * dt * STIFFNESS * rate);
        let shape = |n: f64| (2.0 / count).sqrt() * (part * (n - 0.5)).cos();
        [variance * (shape(count) - shape(1.0)).powi(2), variance * rate / (count - 1.0)]
    };
    (1..BEADS).map(mode).fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
}

#[test]
fn springs_in_heat_have_the_lengths_of_the_scheme_at_any_step() {
    // The fastest mode relaxes by 0.4, 4 and 40 in a step.
    for (dt, steps, skipped) in [(0.1, 900, 200), (1.0, 350, 50), (10.0, 220, 20)] {
        let chains = 36;
        let found = means(&rouse(chains, (dt, steps)), (chains, skipped), |bodies, chain| {
            let at = &bodies.position[BEADS * chain..BEADS * (chain + 1)];
            let bonds = at.windows(2).map(|pair| pair[0].distance_squared(pair[1])).sum::<f64>();
            vec![at[0].distance_squared(at[BEADS - 1]), bonds / (BEADS - 1) as f64]
        });
        let [ends, bond] = of_modes(dt);
        agrees(&format!("dt {dt}"), &found, &[("both ends", ends), ("a bond", bond)]);
    }
    // In equilibrium these are 21 and 3.
    assert!(of_modes(1e-9).into_iter().zip([21.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-6));
}

const RODS: usize = 4;
/// A rod with half of the gap at each end.
const LINK: f64 = 1.1;
const BENDING: f64 = 1.0;
const WARM: f64 = 0.25;

fn worms(chains: usize, (dt, steps): (f64, u64)) -> Value {
    let half = 0.5 * LINK;
    let rod = |i: usize| {
        let [x, y] = [i / RODS % 6, i / RODS / 6].map(|of| 12.0 * of as f64);
        json!({"shape": {"spherocylinder": {"diameter": 0.05, "length": 1.0}},
            "position": [x, y, LINK * (i % RODS) as f64]})
    };
    let bond = |i: usize| {
        let first = i / (RODS - 1) * RODS + i % (RODS - 1);
        json!({"bodies": [first, first + 1], "at": [[0, 0, half], [0, 0, -half]], "stiffness": 100, "implicit": true,
            "bending": BENDING})
    };
    json!({"name": "worms", "seed": 3, "time": {"dt": dt, "end": dt * steps as f64},
        "dynamics": {"overdamped": {"drag": 1.0}}, "thermal": {"temperature": WARM},
        "bodies": (0..chains * RODS).map(rod).collect::<Vec<_>>(),
        "bonds": (0..chains * (RODS - 1)).map(bond).collect::<Vec<_>>()})
}

/// The mean cosine of a bend of this stiffness over `kT` in space.
fn cosine(stiffness: f64) -> f64 {
    let count = 20_000;
    let (mut sum, mut all) = (0.0, 0.0);
    for i in 0..count {
        let angle = PI * (i as f64 + 0.5) / f64::from(count);
        let weight = angle.sin() * (-0.5 * stiffness * angle * angle).exp();
        (sum, all) = (sum + weight * angle.cos(), all + weight);
    }
    sum / all
}

/// The mean square of a worm-like chain of this length and persistence length.
fn kratky_porod(length: f64, persistence: f64) -> f64 {
    2.0 * persistence * length * (1.0 - persistence / length * (1.0 - (-length / persistence).exp()))
}

#[test]
fn stiff_chains_in_heat_are_worm_like() {
    let (chains, dt) = (36, 0.004);
    let found = means(&worms(chains, (dt, 1500)), (chains, 300), |bodies, chain| {
        let rods = RODS * chain..RODS * (chain + 1);
        let turned: Vec<DVec3> = bodies.orientation[rods.clone()].iter().map(|q| *q * DVec3::Z).collect();
        let [first, last] = [rods.start, rods.end - 1].map(|i| bodies.position[i]);
        let ends = last - first + 0.5 * LINK * (turned[0] + turned[RODS - 1]);
        let near = turned.windows(2).map(|pair| pair[0].dot(pair[1])).sum::<f64>() / (RODS - 1) as f64;
        vec![ends.length_squared(), near]
    });
    // Two rods turn against each other with the mobility 24, which is how stiff the scheme makes their bend.
    let stiffness = BENDING / WARM * (1.0 + 0.5 * 24.0 * BENDING * dt);
    let near = cosine(stiffness);
    let between = |i: usize, j: usize| near.powi((i as i32 - j as i32).abs());
    let all: f64 = (0..RODS).flat_map(|i| (0..RODS).map(move |j| between(i, j))).sum();
    let stretch = 3.0 * WARM / 100.0 * (RODS - 1) as f64;
    agrees("rods", &found, &[("both ends", LINK * LINK * all + stretch), ("neighbours", near)]);
    // The same by the formula of Kratky and Porod, of a chain without links.
    let (length, persistence) = (LINK * RODS as f64, -LINK / near.ln());
    let smooth = kratky_porod(length, persistence);
    assert!((smooth / (LINK * LINK * all) - 1.0).abs() < 0.02, "{smooth} {all}");
}
