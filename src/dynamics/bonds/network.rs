//! The stability of all bonds together.
//!
//! A step takes the pulls of all bonds as they are at its start. The stretches `d` of all bonds so become `(1 - dt J M
//! J^T K) d` in an overdamped step, with `J` from the velocities of bodies to those at which the points of bonds part,
//! `M` the mobilities and `K` the stiffnesses; they grow without bound where the largest eigenvalue of `dt J M J^T K`
//! is over 2. With inertia velocities come between, and the bound on `dt^2 J M J^T K`, with `M` the inverse masses, is
//! 4 (the leapfrog's limit); with drag beside inertia it is at least 2 of `dt^2 s(a) J M J^T K`, with `s(a) = (1 -
//! e^-a) / a` and `a` the decay in a step.
//!
//! A bond may come to stand in any direction to its bodies, so that each one counts in all directions, in a planar
//! scene in those of the plane. The eigenvalue is found by power iteration (L. N. Trefethen, D. Bau, *Numerical Linear
//! Algebra*, 1997, lecture 27), which comes to it from below.

use super::Bond;
use crate::dynamics::Dynamics;
use crate::shape::Shape;
use glam::{DMat3, DQuat, DVec3};

/// Rounds of the iteration: at least so many, as what grows most may be a small part of the start, then until the value
/// changes by less than a part of it, and no more than so many. Chains of 2 to 40 balls come within 0.5 %.
const LEAST_ROUNDS: u32 = 50;
const ENOUGH: f64 = 1e-6;
const MOST_ROUNDS: u32 = 300;

/// A body that bonds are fixed to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Member {
    pub shape: Shape,
    /// Its orientation, where it is known.
    pub orientation: Option<DQuat>,
    pub fixed: bool,
}

/// What pulls do to a body in a step: to its centre, and to its turn in space axes.
#[derive(Clone, Copy)]
struct Yield {
    linear: f64,
    turning: DMat3,
}

impl Yield {
    const NONE: Yield = Yield { linear: 0.0, turning: DMat3::ZERO };

    fn of(member: &Member, dynamics: &Dynamics, dt: f64) -> Yield {
        if member.fixed {
            return Yield::NONE;
        }
        let (linear, turning) = dynamics.yields(&member.shape, dt);
        let axes = DMat3::from_quat(member.orientation.unwrap_or(DQuat::IDENTITY));
        Yield { linear, turning: axes * DMat3::from_diagonal(turning) * axes.transpose() }
    }
}

/// A network of bonds that a step makes grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unstable {
    /// The bond that grows most.
    pub bond: usize,
    /// The longest step in which all would be stable.
    pub longest: f64,
}

/// Whether these bonds between `members`, by their numbers, are unstable in steps of `dt`.
pub(crate) fn instability(
    bonds: &[Bond],
    members: &[Member],
    dynamics: &Dynamics,
    planar: bool,
    dt: f64,
) -> Option<Unstable> {
    if bonds.is_empty() {
        return None;
    }
    let yields: Vec<Yield> = members.iter().map(|member| Yield::of(member, dynamics, dt)).collect();
    let arm = |bond: &Bond, end: usize| {
        members[bond.bodies[end]].orientation.unwrap_or(DQuat::IDENTITY) * DVec3::from(bond.at[end])
    };
    let arms: Vec<[DVec3; 2]> = bonds.iter().map(|bond| [arm(bond, 0), arm(bond, 1)]).collect();
    let (largest, bond) = largest_eigenvalue(bonds, &arms, &yields, planar);
    let damped = dynamics.drag_beside_inertia().is_some();
    let bound = if dynamics.has_inertia() && !damped { 4.0 } else { 2.0 };
    // Not a number is unstable.
    if largest <= bound {
        return None;
    }
    let part = bound / largest;
    Some(Unstable { bond, longest: dt * if dynamics.has_inertia() { part.sqrt() } else { part } })
}

/// The largest eigenvalue, and the bond with the largest part in it.
fn largest_eigenvalue(bonds: &[Bond], arms: &[[DVec3; 2]], yields: &[Yield], planar: bool) -> (f64, usize) {
    // Each bond begins otherwise, so that no symmetry of the network hides what grows.
    let begin = |i: usize| {
        let phase = i as f64 + 1.0;
        let aside = DVec3::new((1.3 * phase).sin(), (2.1 * phase).cos(), (3.7 * phase).sin()) + DVec3::splat(0.1);
        // What begins in the plane stays in it.
        if planar { aside.with_z(0.0) } else { aside }
    };
    let mut x: Vec<DVec3> = (0..bonds.len()).map(begin).collect();
    let mut value = 0.0;
    for round in 0..MOST_ROUNDS {
        let norm = x.iter().map(|x| x.length_squared()).sum::<f64>().sqrt();
        x.iter_mut().for_each(|x| *x /= norm);
        let pulled = multiply(bonds, arms, yields, &x);
        let next: f64 = x.iter().zip(&pulled).map(|(a, b)| a.dot(*b)).sum();
        x = pulled;
        let settled = round >= LEAST_ROUNDS && (next - value).abs() <= ENOUGH * next.abs();
        value = next;
        if settled || next == 0.0 || !next.is_finite() {
            break;
        }
    }
    let largest =
        (0..x.len()).fold(0, |most, i| if x[i].length_squared() > x[most].length_squared() { i } else { most });
    (value, largest)
}

/// `K^1/2 J M J^T K^1/2 x`.
fn multiply(bonds: &[Bond], arms: &[[DVec3; 2]], yields: &[Yield], x: &[DVec3]) -> Vec<DVec3> {
    let mut pull = vec![[DVec3::ZERO; 2]; yields.len()];
    for ((bond, arms), x) in bonds.iter().zip(arms).zip(x) {
        let force = bond.stiffness.sqrt() * *x;
        for (end, sign) in [(0, -1.0), (1, 1.0)] {
            let [push, torque] = &mut pull[bond.bodies[end]];
            *push += sign * force;
            *torque += sign * arms[end].cross(force);
        }
    }
    let moved: Vec<[DVec3; 2]> =
        pull.iter().zip(yields).map(|([push, torque], of)| [of.linear * *push, of.turning * *torque]).collect();
    let point = |bond: &Bond, arms: &[DVec3; 2], end: usize| {
        let [linear, turning] = moved[bond.bodies[end]];
        linear + turning.cross(arms[end])
    };
    let parts = bonds.iter().zip(arms);
    parts.map(|(bond, arms)| bond.stiffness.sqrt() * (point(bond, arms, 1) - point(bond, arms, 0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(count: usize, shape: Shape, reach: f64, stiffness: f64) -> (Vec<Bond>, Vec<Member>) {
        let bond = |i: usize| Bond::new([i, i + 1], [[0.0, 0.0, reach], [0.0, 0.0, -reach]], stiffness);
        let member = Member { shape, orientation: Some(DQuat::IDENTITY), fixed: false };
        ((0..count - 1).map(bond).collect(), vec![member; count])
    }

    /// Balls that are bonded at their centres: `4 k M cos^2(pi / 2 n)` of `n` balls.
    #[test]
    fn a_chain_of_balls_is_unstable_from_its_largest_eigenvalue_on() {
        let ball = Shape::Sphere { radius: 0.5 };
        for count in [2, 3, 8, 40] {
            let (bonds, members) = chain(count, ball, 0.0, 50.0);
            let largest = 4.0 * 50.0 * (std::f64::consts::FRAC_PI_2 / count as f64).cos().powi(2);
            let dynamics = Dynamics::Overdamped { drag: 1.0.into() };
            let limit = 2.0 / largest;
            assert_eq!(instability(&bonds, &members, &dynamics, false, 0.99 * limit), None, "{count}");
            let found = instability(&bonds, &members, &dynamics, false, 1.01 * limit).unwrap();
            assert!((found.longest / limit - 1.0).abs() < 5e-3, "{count}: {} {limit}", found.longest);
            let inertial = Dynamics::Inertial { density: 2.0, drag: None };
            let limit = 2.0 / (largest / (2.0 * ball.volume())).sqrt();
            assert_eq!(instability(&bonds, &members, &inertial, false, 0.99 * limit), None, "{count}");
            let found = instability(&bonds, &members, &inertial, false, 1.01 * limit).unwrap();
            assert!((found.longest / limit - 1.0).abs() < 5e-3, "{count}: {} {limit}", found.longest);
        }
    }

    /// The tips of two rods: `1 / xi L` along them and four times that across.
    #[test]
    fn a_joint_of_two_rods_is_stable_in_every_direction() {
        let rod = Shape::Spherocylinder { diameter: 0.2, length: 2.0 };
        let (bonds, members) = chain(2, rod, 0.5 * rod.major_axis(), 10.0);
        let limit = 2.0 / (10.0 * 8.0 / rod.major_axis());
        let dynamics = Dynamics::Overdamped { drag: 1.0.into() };
        assert_eq!(instability(&bonds, &members, &dynamics, false, 0.999 * limit), None);
        assert!(instability(&bonds, &members, &dynamics, false, 1.001 * limit).is_some());
        let held = [Member { fixed: true, ..members[0] }, members[1]];
        assert_eq!(instability(&bonds, &held, &dynamics, false, 1.99 * limit), None);
        assert!(instability(&bonds, &held, &dynamics, false, 2.01 * limit).is_some());
    }
}
