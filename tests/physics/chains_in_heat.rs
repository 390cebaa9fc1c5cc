//! Chains of beads in heat against theory: chains of springs at any stiffness times `dt`, rigid bonds, stiff chains.
//! Each figure is within three standard errors, from one seed. Beads do not collide, and chains are a sample.
//!
//! `RELCP_CHAIN_SAMPLES=N` takes more samples of each chain.

use crate::scenes::watch;
use glam::DVec3;
use relcp::bodies::Bodies;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// Of a bead that is a point.
const POINT: f64 = 0.005;

/// Samples of each chain in a `cargo test`.
const SAMPLES: usize = 8;

fn samples() -> usize {
    std::env::var("RELCP_CHAIN_SAMPLES").map_or(SAMPLES, |samples| samples.parse().unwrap())
}

/// Straight chains of `beads` beads, 1 apart, far from each other. A bead has the resistance 1 to moving.
struct Chains {
    count: usize,
    beads: usize,
    radius: f64,
    heat: f64,
    dt: f64,
}

impl Chains {
    fn scene(&self, bond: &Value, steps: usize) -> Value {
        let place = |i: usize| [(i % self.beads) as f64, 1e3 * (i / self.beads) as f64, 0.0];
        let shape = json!({"sphere": {"radius": self.radius}});
        let bodies: Vec<Value> =
            (0..self.count * self.beads).map(|i| json!({"shape": shape, "position": place(i)})).collect();
        let bonds: Vec<Value> = (0..bodies.len()).flat_map(|i| self.bonds_of(bond, i)).collect();
        json!({"name": "chains", "seed": 5, "time": {"dt": self.dt, "end": self.dt * steps as f64},
            "dynamics": {"overdamped": {"drag": 0.5 / self.radius}}, "thermal": {"temperature": self.heat}, "bodies": bodies,
            "bonds": bonds})
    }

    /// The bonds of a bead with later ones: `bond` with the next, and bonds that do not pull, which keep contact off.
    fn bonds_of(&self, bond: &Value, i: usize) -> impl Iterator<Item = Value> {
        (i + 1..i + self.beads - i % self.beads).map(move |j| {
            let idle = json!({"at": [[0, 0, 0], [0, 0, 0]], "stiffness": 1e-12, "implicit": false, "contact": false});
            let mut bond = if j == i + 1 { bond.clone() } else { idle };
            bond["bodies"] = json!([i, j]);
            bond
        })
    }

    /// A value of each chain, `samples()` times, `every` steps apart, after three times as many at first.
    fn values(&self, bond: &Value, every: usize, value: impl Fn(&[DVec3]) -> f64) -> Vec<f64> {
        let (mut found, mut step) = (Vec::new(), 0);
        watch(&self.scene(bond, every * (samples() + 3)), |bodies: &Bodies| {
            step += 1;
            if step > 3 * every + 1 && (step - 1) % every == 0 {
                found.extend(bodies.position.chunks(self.beads).map(&value));
            }
        });
        assert_eq!(found.len(), self.count * samples());
        found
    }
}

/// Asserts that the mean of a sample is within three standard errors of what it should be.
fn within_three(name: &str, sample: &[f64], expected: f64) {
    let n = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / n;
    let error = (sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
    let errors = (mean - expected) / error;
    println!("{name}: {mean:.5}, theory {expected:.5}, {errors:+.2} standard errors of {n} samples");
    assert!(errors.abs() < 3.0, "{name}");
}

fn end_to_end(chain: &[DVec3]) -> f64 {
    chain[0].distance_squared(chain[chain.len() - 1])
}

/// The mean square of the distance of beads `a` and `b` of a chain of springs of rest length 0, by Rouse's modes (M.
/// Doi and S. F. Edwards, *The Theory of Polymer Dynamics*, 1986, chapter 4). Implicit Euler takes a mode of the
/// stiffness `s` to `(x + heat) / (1 + s dt)` in a step, at a resistance of 1. Its variance is then `kT / s / (1 + s dt
/// / 2)`.
fn by_modes(chains: &Chains, stiffness: f64, (a, b): (usize, usize)) -> f64 {
    let n = chains.beads as f64;
    let mode = |p: usize| {
        let s = stiffness * (2.0 - 2.0 * (PI * p as f64 / n).cos());
        let variance = chains.heat / s / (1.0 + 0.5 * s * chains.dt);
        let at = |bead: usize| (2.0 / n).sqrt() * (PI * p as f64 * (bead as f64 + 0.5) / n).cos();
        3.0 * variance * (at(a) - at(b)).powi(2)
    };
    (1..chains.beads).map(mode).sum()
}

#[test]
fn chains_of_springs_have_the_sizes_of_their_modes_at_any_step() {
    // Stiffness times `dt` over the resistance: resolved steps, and steps far longer than a bond's time.
    for (dt, every) in [(0.04, 100), (1.0, 8), (100.0, 3)] {
        let chains = Chains { count: 60, beads: 4, radius: POINT, heat: 1.0 / 3.0, dt };
        let bond = json!({"at": [[0, 0, 0], [0, 0, 0]], "stiffness": 1.0, "implicit": true, "contact": false});
        let size = chains.values(&bond, every, end_to_end);
        within_three(&format!("dt {dt}: end to end"), &size, by_modes(&chains, 1.0, (0, 3)));
        let bond_length = chains.values(&bond, every, |chain| chain[1].distance_squared(chain[2]));
        within_three(&format!("dt {dt}: bond"), &bond_length, by_modes(&chains, 1.0, (1, 2)));
    }
}

/// Rigid bonds take motions along them out of heat, as in mechanics with constraints: the angle between two bonds has
/// the density `sin(t) sqrt(4 - cos(t)^2)`, not that of a stiff spring's limit, `sin(t)` (H. A. Kramers, *Journal of
/// Chemical Physics* 14, 415, 1946). The mean square of the cosine is 0.3210, and would be 1/3.
#[test]
fn three_beads_with_rigid_bonds_have_the_angles_of_constrained_ones() {
    let chains = Chains { count: 100, beads: 3, radius: POINT, heat: 1.0, dt: 0.005 };
    let bond = json!({"at": [[0, 0, 0], [0, 0, 0]], "stiffness": "rigid", "length": 1.0, "contact": false});
    let cosine = |chain: &[DVec3]| (chain[1] - chain[0]).dot(chain[2] - chain[1]);
    let cosines = chains.values(&bond, 120, cosine);
    within_three("cosine", &cosines, 0.0);
    let squares: Vec<f64> = cosines.iter().map(|x| x * x).collect();
    let angles = || (0..10_000).map(|i| 2.0 * (f64::from(i) + 0.5) / 10_000.0 - 1.0);
    let weight = |x: f64| (4.0 - x * x).sqrt();
    within_three(
        "square of the cosine",
        &squares,
        angles().map(|x| x * x * weight(x)).sum::<f64>() / angles().map(weight).sum::<f64>(),
    );
}

/// A stiff chain of `n` rigid bonds, 1 long, whose neighbours have the mean cosine `c`, has the mean square distance
/// between its ends `n (1 + c) / (1 - c) - 2 c (1 - c^n) / (1 - c)^2`, and as a whole that of Kratky and Porod. Its
/// persistence length is 20 bonds.
#[test]
fn a_stiff_chain_has_the_size_of_a_worm() {
    let chains = Chains { count: 20, beads: 6, radius: 0.5, heat: 0.05, dt: 0.01 };
    let stiffness = 1.0;
    let bond = json!({"at": [[0, 0, 0], [0, 0, 0]], "stiffness": "rigid", "length": 1.0, "contact": false,
        "bending": {"stiffness": stiffness, "axes": [[1, 0, 0], [1, 0, 0]]}});
    let size = chains.values(&bond, 150, end_to_end);
    let angles = || (0..10_000).map(|i| (f64::from(i) + 0.5) * PI / 10_000.0);
    let density = |t: f64| (-0.5 * stiffness * t * t / chains.heat).exp() * t.sin();
    let c = angles().map(|t| t.cos() * density(t)).sum::<f64>() / angles().map(density).sum::<f64>();
    let n = chains.beads as f64 - 1.0;
    within_three("end to end", &size, n * (1.0 + c) / (1.0 - c) - 2.0 * c * (1.0 - c.powf(n)) / (1.0 - c).powi(2));
    let persistence = stiffness / chains.heat;
    let worm = 2.0 * persistence * n * (1.0 - persistence / n * (1.0 - (-n / persistence).exp()));
    println!("a worm of Kratky and Porod: {worm:.5}");
}
