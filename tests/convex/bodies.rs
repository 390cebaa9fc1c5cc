//! Support functions, and random poses.

use glam::{DQuat, DVec3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use relcp::separation::Placed;
use relcp::shape::{Convex, Shape};

pub fn ellipsoid(radii: [f64; 3]) -> Convex {
    let radii = DVec3::from_array(radii);
    Convex::new(move |n: DVec3| radii * radii * n / (radii * n).length()).unwrap()
}

/// Three needles and a ball added up: a cube of half side 1.2, rounded by about `s`.
pub fn die(s: f64) -> Convex {
    Convex::new(move |n: DVec3| 0.2 * n + needles(n, s)).unwrap()
}

pub fn needles(n: DVec3, s: f64) -> DVec3 {
    // The gradient of the sum of sqrt(n_i^2 + s^2 |n|^2).
    let heights = n.to_array().map(|c| c.hypot(s));
    let along = DVec3::from_array([0, 1, 2].map(|i| n[i] / heights[i]));
    along + n * (s * s * heights.iter().map(|h| 1.0 / h).sum::<f64>())
}

/// A spheroid with one end blunter than the other. `h = |(n_x, n_y, 1.3 n_z)| + c n_z^3`, moved to its centre of mass.
pub fn egg_point(n: DVec3) -> DVec3 {
    const CUBIC: f64 = 0.06;
    let radii = DVec3::new(1.0, 1.0, 1.3);
    let round = radii * radii * n / (radii * n).length();
    let cubic = CUBIC * (3.0 * n.z * n.z * DVec3::Z - 2.0 * n.z.powi(3) * n);
    round + cubic - EGG_CENTRE * DVec3::Z
}

/// Measured: what [`Convex::new`] says where nothing is taken off.
pub const EGG_CENTRE: f64 = 0.030510133683;

pub fn egg() -> Convex {
    Convex::new(egg_point).unwrap()
}

/// `x^4 + y^4 + z^4 = 1`: smooth and strictly convex, but without curvature where it meets the axes.
pub fn superball() -> Convex {
    Convex::new(|n: DVec3| {
        let sum = n.abs().powf(4.0 / 3.0).element_sum();
        n.signum() * n.abs().powf(1.0 / 3.0) / sum.powf(0.25)
    })
    .unwrap()
}

pub fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub fn placed(shape: Shape, position: DVec3, orientation: DQuat) -> Placed {
    Placed { shape, position, orientation }
}
