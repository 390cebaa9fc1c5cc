//! Brownian motion: a random load on each body, steady over a step, of the strength that the law's resistance asks for.
//!
//! Overdamped bodies have the load `sqrt(2 kT zeta / dt) xi` with `zeta` the resistance `xi L`, and the torque likewise
//! with `xi L^3 / 12`; the mobility makes of it displacements of variance `2 kT M dt` (the scheme of Euler and
//! Maruyama; D. L. Ermak, J. A. McCammon, J. Chem. Phys. 69, 1352 (1978)). The resistance of this law is the same in
//! all directions and at all places: its divergence is zero, and no drift is added.
//!
//! Bodies with inertia and drag have the load that gives velocities `e^-a u + sqrt(kT / m (1 - e^-2a)) xi` at the
//! step's end, the exact solution of Langevin's equation over the step, so that the variance of a free body's velocity
//! is `kT / m` for every step size; and about each principal axis likewise.
//!
//! The numbers are [drawn](draw) from the seed, the body's id and the step's number, and so are the same in any order,
//! on any number of threads, and on a device. A step that is taken in pieces has the load of the whole step in each.

pub mod draw;

use super::damping::rates;
use super::overdamped::resistances;
use super::{Dynamics, Load};
use crate::shape::Shape;
use draw::normals;
use glam::{DQuat, DVec3};

/// Brownian motion with the law's own mobility.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Thermal {
    /// Boltzmann's constant times the temperature, an energy.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub temperature: f64,
}

impl Thermal {
    /// At this temperature, an energy.
    pub const fn new(temperature: f64) -> Thermal {
        Thermal { temperature }
    }
}

/// The random loads of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heat {
    /// Their temperature.
    pub thermal: Thermal,
    /// The scene's seed.
    pub seed: u64,
    /// The law, whose resistance they belong to.
    pub dynamics: Dynamics,
    /// Whether bodies move in the x-y plane.
    pub planar: bool,
}

impl Heat {
    /// The load on the body `id` in step number `step`, of length `dt`.
    pub fn load(&self, shape: &Shape, orientation: DQuat, (id, step): (u64, u64), dt: f64) -> Load {
        let [a, b, c, d, e, f] = normals(self.seed, id, step);
        let (force, torque) = self.strength(shape, dt);
        let load = Load { force: force * DVec3::new(a, b, c), torque: orientation * (torque * DVec3::new(d, e, f)) };
        if self.planar { load.in_plane() } else { load }
    }

    /// Standard deviations of the force, along any axis, and of the torques about the principal axes.
    fn strength(&self, shape: &Shape, dt: f64) -> (f64, DVec3) {
        let temperature = self.thermal.temperature;
        match self.dynamics {
            Dynamics::Overdamped { drag } => {
                let (linear, turning) = resistances(drag, shape);
                let of = |resistance: f64| (2.0 * temperature * resistance / dt).sqrt();
                (of(linear), DVec3::splat(of(turning)))
            }
            Dynamics::Inertial { density, drag } => {
                // Without drag there is no random load; validation refuses such a scene.
                let Some(drag) = drag else { return (0.0, DVec3::ZERO) };
                let (linear, turning) = resistances(drag, shape);
                let (rate, rates) = rates(drag, density, shape);
                let of = |resistance: f64, rate: f64| (temperature * resistance * rate * spread(rate * dt)).sqrt();
                (of(linear, rate), rates.map(|rate| of(turning, rate)))
            }
        }
    }
}

/// `(1 + e^-a) / (1 - e^-a)`.
fn spread(a: f64) -> f64 {
    (1.0 + (-a).exp()) / -(-a).exp_m1()
}
