//! The scene: spherocylinders on a cubic lattice, each turned at random, drawn together.

use crate::StudyError;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::scene::{Body, Scene};
use relcp::shape::Shape;

/// Twice the radius.
pub(super) const DIAMETER: f64 = 0.5;

/// From tip to tip.
pub(super) const LENGTH: f64 = 1.5;

/// Between neighbours of the lattice: rods of any orientation keep clear of each other.
pub(super) const SPACING: f64 = 1.6;

/// The run's end.
pub(super) const END: f64 = 15.0;

/// The seed of orientations.
pub(super) const SEED: u64 = 1;

/// The scene of `side^3` rods. The drag is one over the length, so that a unit force moves a rod with unit speed, and
/// the rotational mobility is `12 / L^2`.
pub fn scene(side: u32, dt: f64) -> Result<Scene, StudyError> {
    let sets = [("time.dt", dt), ("time.end", END), ("dynamics.overdamped.drag", 1.0 / LENGTH)];
    let mut scene = Scene::load("compaction", sets.map(|(key, value)| format!("{key}={value}")))?;
    scene.name = format!("packing-{}", side.pow(3));
    scene.seed = SEED;
    scene.generate.clear();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let at = |k: u32| SPACING * (f64::from(k) - 0.5 * (f64::from(side) - 1.0));
    let places = (0..side).flat_map(|i| (0..side).flat_map(move |j| (0..side).map(move |k| [i, j, k])));
    let shape = Shape::Spherocylinder { diameter: DIAMETER, length: LENGTH };
    scene.bodies = places.map(|place| body(shape, place.map(at), orientation(&mut random))).collect();
    Ok(scene)
}

fn body(shape: Shape, position: [f64; 3], orientation: [f64; 4]) -> Body {
    with!(orientation: Some(orientation), ..Body::new(shape, position))
}

/// An isotropic rotation: the direction of a uniform point of the four-dimensional unit ball, away from its centre.
fn orientation(random: &mut ChaCha8Rng) -> [f64; 4] {
    loop {
        let q = random.random::<[f64; 4]>().map(|u| 2.0 * u - 1.0);
        let square: f64 = q.iter().map(|x| x * x).sum();
        if (0.01..=1.0).contains(&square) {
            return q.map(|x| x / square.sqrt());
        }
    }
}
