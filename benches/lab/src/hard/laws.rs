//! What must hold in every step of a case: links stay, no body passes another, momentum is kept, contact adds no
//! energy.

use super::energy::{Energy, of_motion, turning};
use super::verdict::Measure;
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::Dynamics;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use relcp::step::contacts;

/// A law that a case is held to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Each ring stays linked with the next.
    Linked,
    /// Bodies that stand in each other's way along x stay in their order.
    InOrder,
    /// The momentum of all bodies together.
    Momentum,
    /// Contact adds no kinetic energy beyond the work that parts what overlapped, within the tolerance, at the step's
    /// start.
    Energy,
    /// All energy together, that of gravity and the like too, never grows.
    NoGain,
    /// Each body that turns freely keeps its energy and its angular momentum.
    Spin,
}

/// Of the most energy of motion. The cases are at 6e-6 at most, and one with a scheme that gains energy is over 1 in
/// some steps.
const GAIN_BOUND: f64 = 1e-2;
/// Some rounding a step, over a thousand steps.
const SPIN_BOUND: f64 = 1e-10;
/// A momentum is a sum of about a hundred terms, changed by a solve's sums in each of a hundred steps.
const MOMENTUM_ROUNDING: f64 = 1e-12;
/// Of the energy at the start. A contact that closes may add the square of a step's gyroscopic change of velocity
/// (`docs/timestep.md`): 1.1e-9 in the case of 27 ellipsoids.
const ENERGY_BOUND: f64 = 1e-8;

/// The worst so far.
pub(super) struct Watch {
    law: Law,
    worst: f64,
    first_energy: Option<f64>,
    all_energy: Option<Energy>,
    first: Option<Bodies>,
}

impl Watch {
    pub(super) fn new(law: Law) -> Self {
        Watch { law, worst: 0.0, first_energy: None, all_energy: None, first: None }
    }

    /// Looks at a step: the bodies before it, and the simulation after it.
    pub(super) fn see(&mut self, before: &Bodies, simulation: &Simulation) {
        let Ok(state) = simulation.state() else { return };
        let after = &state.bodies;
        let found = match self.law {
            Law::Linked => self.worst + f64::from(u8::from(!linked(after))),
            Law::InOrder => self.worst + f64::from(u8::from(!in_order(after))),
            Law::Momentum => momentum_change(before, after),
            Law::Energy => self.energy_gain(before, simulation),
            Law::NoGain => self.rise(before, simulation),
            Law::Spin => spin_change(self.first.get_or_insert_with(|| before.clone()), after),
        };
        // Not `max`, which takes the other where one is not a number.
        if found > self.worst || found.is_nan() {
            self.worst = found;
        }
    }

    pub(super) fn measure(&self) -> Measure {
        let (what, bound) = match self.law {
            Law::Linked => ("steps with a link lost", 0.0),
            Law::InOrder => ("steps with a body on the other side of another", 0.0),
            Law::Momentum => ("change of momentum in a step, of the sum of magnitudes", MOMENTUM_ROUNDING),
            Law::Energy => {
                ("energy that a step's contact adds beyond parting overlaps, of that at the start", ENERGY_BOUND)
            }
            Law::NoGain => ("energy from nowhere, of the most energy of motion before it", GAIN_BOUND),
            Law::Spin => ("change of a body's energy or angular momentum since the start, of itself", SPIN_BOUND),
        };
        let by_passing = matches!(self.law, Law::Linked | Law::InOrder);
        Measure { what, value: self.worst, bound, by_passing }
    }

    /// What there is more of than at any time before.
    fn rise(&mut self, before: &Bodies, simulation: &Simulation) -> f64 {
        let (Ok(state), scene) = (simulation.state(), simulation.scene()) else { return f64::NAN };
        if self.all_energy.is_none() {
            self.all_energy = Energy::of(scene);
        }
        let Some(energy) = &mut self.all_energy else { return f64::NAN };
        energy.see(before, &state.bodies, scene);
        energy.gain().unwrap_or(f64::NAN)
    }

    /// Kinetic energy after the step's contact less that of the same step without it, less the work that parts
    /// overlaps.
    fn energy_gain(&mut self, before: &Bodies, simulation: &Simulation) -> f64 {
        let (Ok(state), Dynamics::Inertial { density, drag: None }) = (simulation.state(), simulation.scene().dynamics)
        else {
            return f64::NAN;
        };
        // Without contact it would be kept.
        let without = energy(before, density);
        let first = *self.first_energy.get_or_insert(without);
        let with = energy(&state.bodies, density);
        let force = |pair: [usize; 2]| -> f64 {
            state.warm.iter().filter(|warm| warm.pair.map(|i| i as usize) == pair).map(|warm| warm.gamma).sum()
        };
        let parting: f64 = contacts(before, 0.0).iter().map(|near| -near.separation * force(near.bodies)).sum();
        (with - without - parting) / first
    }
}

fn energy(bodies: &Bodies, density: f64) -> f64 {
    (0..bodies.len()).map(|i| of_motion(bodies, i, density)).sum()
}

/// The largest change of a body's energy or angular momentum, of itself.
fn spin_change(first: &Bodies, after: &Bodies) -> f64 {
    let of = |i: usize| {
        let (momentum, energy) = (turning(first, i), of_motion(first, i, 1.0));
        let turned = (turning(after, i) - momentum).length() / momentum.length();
        turned.max((of_motion(after, i, 1.0) / energy - 1.0).abs())
    };
    (0..first.len()).map(of).fold(0.0, f64::max)
}

/// Change of the sum of momenta over the sum of their magnitudes; the density does not matter.
fn momentum_change(before: &Bodies, after: &Bodies) -> f64 {
    let own = |bodies: &Bodies, i: usize| bodies.shape[i].volume() * bodies.velocity[i];
    let change: DVec3 = (0..before.len()).map(|i| own(after, i) - own(before, i)).sum();
    let all: f64 = (0..before.len()).map(|i| own(before, i).length()).sum();
    change.length() / all
}

/// Whether bodies that stand in each other's way along x stand there in their order: one that was squeezed out sideways
/// stands in nobody's.
fn in_order(bodies: &Bodies) -> bool {
    (1..bodies.len()).all(|b| {
        let between = bodies.position[b] - bodies.position[b - 1];
        let reach = bodies.shape[b].bounding_radius() + bodies.shape[b - 1].bounding_radius();
        between.x > 0.0 || between.y.hypot(between.z) >= reach
    })
}

/// Whether the centreline of each ring passes once through the disc of the one before it.
fn linked(bodies: &Bodies) -> bool {
    (1..bodies.len()).all(|i| link(bodies, i - 1, i))
}

fn link(bodies: &Bodies, a: usize, b: usize) -> bool {
    let (Shape::Torus { major_radius: radius, .. }, Shape::Torus { major_radius, .. }) =
        (bodies.shape[a], bodies.shape[b])
    else {
        return false;
    };
    let axis = bodies.orientation[a] * DVec3::Z;
    let offset = bodies.position[b] - bodies.position[a];
    // Points of b's centreline are offset + R (cos t u + sin t v); they cross the plane of a where p cos t + q sin t =
    // r.
    let (u, v) = (bodies.orientation[b] * DVec3::X, bodies.orientation[b] * DVec3::Y);
    let [p, q, r] = [major_radius * axis.dot(u), major_radius * axis.dot(v), -axis.dot(offset)];
    let amplitude = p.hypot(q);
    if amplitude <= r.abs() {
        return false;
    }
    let (middle, half) = (q.atan2(p), (r / amplitude).acos());
    let within = |t: f64| (offset + major_radius * (t.cos() * u + t.sin() * v)).length() < radius;
    within(middle - half) != within(middle + half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use relcp::separation::Placed;
    use std::f64::consts::FRAC_PI_2;

    fn rings(at: [f64; 3], turned: DQuat) -> Bodies {
        let mut bodies = Bodies::default();
        let shape = Shape::Torus { major_radius: 1.0, minor_radius: 0.1 };
        bodies.push(Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY }, 0);
        bodies.push(Placed { shape, position: at.into(), orientation: turned }, 0);
        bodies
    }

    #[test]
    fn links_are_told_from_rings_that_are_none() {
        let across = DQuat::from_rotation_x(FRAC_PI_2);
        assert!(linked(&rings([1.5, 0.0, 0.0], across)) && linked(&rings([-0.5, 0.0, 0.3], across)));
        // Beside it, through the disc twice, above it, in its plane, in a parallel one.
        assert!(!linked(&rings([2.1, 0.0, 0.0], across)) && !linked(&rings([0.0, 0.0, 0.999], across)));
        assert!(!linked(&rings([0.5, 0.0, 1.2], across)) && !linked(&rings([0.5, 0.0, 0.0], DQuat::IDENTITY)));
        assert!(!linked(&rings([0.5, 0.0, 0.1], DQuat::IDENTITY)));
    }

    #[test]
    fn order_and_momentum_see_a_change() {
        let mut bodies = rings([1.5, 0.0, 0.0], DQuat::IDENTITY);
        bodies.velocity = vec![DVec3::X, -DVec3::X];
        assert!(in_order(&bodies));
        let mut after = bodies.clone();
        after.velocity = vec![DVec3::ZERO; 2];
        assert_eq!(momentum_change(&bodies, &after), 0.0);
        after.velocity[1] = 1e-3 * DVec3::Y;
        assert!((momentum_change(&bodies, &after) - 5e-4).abs() < 1e-15);
        after.position.swap(0, 1);
        assert!(!in_order(&after));
        after.position[0].y = 10.0;
        assert!(in_order(&after), "squeezed out sideways");
        // A ball at rest that is set in motion gains what it then has.
        let gain = energy(&after, 2.0);
        assert!((gain / (1e-6 * after.shape[1].volume()) - 1.0).abs() < 1e-12);
    }
}
