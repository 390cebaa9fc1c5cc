//! Brownian motion: a random load on each body, steady over a step, of the strength that the law's resistance asks for.
//!
//! Overdamped bodies have the load `sqrt(2 kT zeta / dt) xi` with `zeta` the resistance `xi L`, and the torque likewise
//! with `xi L^3 / 12`; the mobility makes of it displacements of variance `2 kT M dt` (the scheme of Euler and
//! Maruyama; D. L. Ermak, J. A. McCammon, J. Chem. Phys. 69, 1352 (1978)). No drift is added, since the mobility `M`
//! has no divergence: it is the same at all places, and that of turning is constant in the body's own axes, about which
//! the random turns are drawn. With [drag](super::Drag) that depends on the direction `M` turns with the body, and both
//! hold as well: motion and turning are not coupled, so that `M` changes by turns that are independent of the random
//! force.
//!
//! Bodies with inertia and drag have the load that gives velocities `e^-a u + sqrt(kT / m (1 - e^-2a)) xi` at the
//! step's end, the exact solution of Langevin's equation over the step, so that the variance of a free body's velocity
//! is `kT / m` for every step size; and about each principal axis likewise.
//!
//! The numbers are [drawn](draw) from the seed, the body's id and the step's number, and so are the same in any order,
//! on any number of threads, and on a device. A step that is taken in pieces has the load of the whole step in each.

pub mod draw;

use super::along::Along;
use super::damping::rates;
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
        // Where drag depends on the direction, balls too have their force drawn along their own axes.
        let by_axes = self.dynamics.any_drag().is_some_and(|drag| drag.even().is_none());
        let force = match force {
            Along::Even(force) if !by_axes => force * DVec3::new(a, b, c),
            force => orientation * (force.axes() * DVec3::new(a, b, c)),
        };
        let load = Load { force, torque: orientation * (torque * DVec3::new(d, e, f)) };
        if self.planar { load.in_plane() } else { load }
    }

    /// Standard deviations of the force and of the torques along the principal axes.
    fn strength(&self, shape: &Shape, dt: f64) -> (Along, DVec3) {
        let temperature = self.thermal.temperature;
        match self.dynamics {
            Dynamics::Overdamped { drag } => {
                let resistance = drag.resistance(shape);
                let of = |resistance: f64| (2.0 * temperature * resistance / dt).sqrt();
                (resistance.linear.with(of), resistance.turning.axes().map(of))
            }
            Dynamics::Inertial { density, drag } => {
                // Without drag there is no random load; validation refuses such a scene.
                let Some(drag) = drag else { return (Along::Even(0.0), DVec3::ZERO) };
                let resistance = drag.resistance(shape);
                let (linear, turning) = rates(drag, density, shape);
                let of = |resistance: f64, rate: f64| (temperature * resistance * rate * spread(rate * dt)).sqrt();
                let of_axes = |resistances: DVec3, rates: DVec3| {
                    let of = |axis: usize| of(resistances[axis], rates[axis]);
                    DVec3::new(of(0), of(1), of(2))
                };
                let force = match (resistance.linear, linear) {
                    (Along::Even(resistance), Along::Even(rate)) => Along::Even(of(resistance, rate)),
                    (resistances, rates) => Along::Axes(of_axes(resistances.axes(), rates.axes())),
                };
                (force, of_axes(resistance.turning.axes(), turning))
            }
        }
    }
}

/// `(1 + e^-a) / (1 - e^-a)`.
fn spread(a: f64) -> f64 {
    (1.0 + (-a).exp()) / -(-a).exp_m1()
}
