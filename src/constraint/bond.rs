//! The rows of an implicit bond.
//!
//! A bond of stiffness `k` and length `l` between the points `x_a` and `x_b` has the row
//!
//! ```text
//! g = |d| - l + gamma / k = 0,   d = x_b - x_a at the step's end
//! ```
//!
//! whose multiplier is free: `gamma` is a force under every law, positive where the bond pushes, so that the compliance
//! is `1 / k`, and zero for a rigid bond. The row is affine as every row: made at `C_j`, it has the direction of `d`
//! there. A bond of length 0 has a row an axis of space, `d_i + gamma_i / k = 0`, which are a ball joint where it is
//! rigid.
//!
//! The step is implicit Euler's: a row is made again at the trial until its gap and its direction are those of the
//! step's end. As a tense bond turns, so does its pull, and as a body turns, so do its points. Where that moves the
//! points by more than what they have turned by, making rows again would not converge. The bond then has further rows,
//! the geometric stiffness of Newton's method, with the pull `F` of the last solve; at its limit their multipliers are
//! zero:
//!
//! ```text
//! t . d + gamma |d| / T = 0              across the bond, with the tension T
//! t . (w x r) dt + gamma r^2 / F . r = 0     across the arm r of a body's point, on which the pull F acts
//! ```
//!
//! The rows of bends and turns are in [`super::turning`].

use super::friction::tangents;
use super::turning as turns;
use super::{Mover, Row, row, torque_arm};
use crate::dynamics::Turn;
use crate::freedom::{PLANAR, pack};
use crate::separation::Separation;
use glam::DVec3;

/// A bond has further rows where its pull would move its points by this part of what they turn aside.
const TURNS_BACK: f64 = 0.1;

/// The axes of space.
const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

/// Where a bond is, and what it is.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// From the centre of each body to its point, space axes.
    pub arms: [DVec3; 2],
    /// From the first point to the second.
    pub way: DVec3,
    /// The rest length.
    pub length: f64,
    /// The inverse of the stiffness; none where it does not resist its stretch.
    pub compliance: Option<f64>,
    /// The turns that it resists.
    pub turns: Vec<Turn>,
    /// The length at which their angles count.
    pub reach: f64,
    /// The force on the second body at the last solve, zero before the first.
    pub pull: DVec3,
}

/// A row whose multiplier is free.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<const D: usize> {
    pub row: Row<D>,
    pub compliance: f64,
    /// Where the force of a multiplier of 1 on the second body points; zero where it is a torque.
    pub direction: DVec3,
    /// The torque of a multiplier of 1 on the second body about the bond's end there.
    pub couple: DVec3,
}

impl<const D: usize> Line<D> {
    /// The square of the length of its row: its diagonal entry of the matrix.
    pub fn square(&self) -> f64 {
        self.row.0.as_flattened().iter().map(|j| j * j).sum()
    }
}

/// The rows of a bond, and how many of them are its own; its further ones are last.
pub(crate) fn lines<const D: usize>(of: &Stretch, movers: [Mover<'_>; 2], dt: f64) -> (Vec<Line<D>>, usize) {
    let [lever_a, lever_b] = of.arms;
    let line = |direction: DVec3, separation: f64, compliance: f64| {
        let found = Separation { separation, normal: direction, lever_a, lever_b };
        Line { row: row(&found, movers, dt), compliance, direction, couple: DVec3::ZERO }
    };
    let (mut own, mut further) = (Vec::new(), Vec::new());
    if let Some(compliance) = of.compliance.filter(|_| of.length == 0.0) {
        let axes = AXES.into_iter().take(if D == PLANAR { 2 } else { 3 });
        own.extend(axes.map(|axis| line(axis, axis.dot(of.way), compliance)));
    } else if let Some(compliance) = of.compliance {
        let distance = of.way.length();
        // Two points that are one part along x.
        let along = if distance > 0.0 { of.way / distance } else { DVec3::X };
        let stretch = line(along, distance - of.length, compliance);
        let tension = -of.pull.dot(along);
        let turns_back = tension * stretch.square() > TURNS_BACK * distance;
        own.push(stretch);
        if turns_back && distance > 0.0 {
            further.extend(across::<D>(along).map(|across| line(across, 0.0, distance / tension)));
        }
    }
    own.extend(of.turns.iter().flat_map(|turn| turns::lines(of, turn, movers, dt)));
    for (end, force) in [(0, -of.pull), (1, of.pull)] {
        let (arm, holds) = (of.arms[end], force.dot(of.arms[end]));
        if holds > 0.0 {
            let turns = across::<D>(arm.normalize()).map(|across| turning(end, (arm, across), holds, movers, dt));
            further.extend(turns.filter(|turn| turn.square() > TURNS_BACK * turn.compliance));
        }
    }
    let count = own.len();
    own.extend(further);
    (own, count)
}

/// The directions across another.
fn across<const D: usize>(along: DVec3) -> impl Iterator<Item = DVec3> {
    tangents::<D>(along).into_iter().take(if D == PLANAR { 1 } else { 2 })
}

/// The row of the turn of one of the bodies that moves the end of its arm across it.
fn turning<const D: usize>(
    end: usize,
    (arm, across): (DVec3, DVec3),
    holds: f64,
    movers: [Mover<'_>; 2],
    dt: f64,
) -> Line<D> {
    let Mover { motion, reached_with, .. } = movers[end];
    let torque = torque_arm(arm, across, reached_with.angular, dt);
    let compliance = arm.length_squared() / holds;
    let mut jacobian = [[0.0; D]; 2];
    jacobian[end] = pack::<D>(DVec3::ZERO, dt.sqrt() * (motion.factor.rotation * torque));
    let to_come = dt * torque.dot(motion.free.angular - reached_with.angular);
    Line { row: (jacobian, to_come), compliance, direction: DVec3::ZERO, couple: DVec3::ZERO }
}
