//! The flow of a periodic cell whose lengths change: `u_i = e_i(t) x_i`, with the strain rates `e_i = r_i / (1 + r_i
//! t)` of lengths `h_i = h_i(0) (1 + r_i t)` (the engineering strain rates `r_i` are those of LAMMPS' `fix deform ...
//! erate`).
//!
//! It carries bodies as any flow does, by drag: those of the overdamped law go with the cell, and turn with the strain
//! about each axis as Jeffery's equation says (`flow.rs`). Images of a body are carried like it, as the cell's sides
//! go with the same flow. An Euler step from `t` takes an undisturbed body by `dt e_i(t) x_i`, and the cell by the same
//! part of its length, exactly.

use super::flow::{yzx, zxy};
use super::overdamped::resistances;
use super::{Dynamics, ForceField, Load};
use crate::bodies::Bodies;
use crate::periodic::{Periodic, Periods};
use glam::DVec3;

/// The flow of a scene's cell and the resistance to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    cell: Periodic,
    /// The law's drag coefficient.
    drag: f64,
    /// Whether bodies move in the x-y plane.
    planar: bool,
}

impl Strain {
    /// That of a cell whose lengths change, under a law that has drag; none under one without.
    pub fn new(cell: &Periodic, dynamics: &Dynamics, planar: bool) -> Option<Strain> {
        let drag = dynamics.drag().or(dynamics.drag_beside_inertia())?;
        cell.strain_rate.map(|_| Strain { cell: *cell, drag, planar })
    }

    /// The periods at `time`.
    pub fn periods(&self, time: f64) -> Periods {
        self.cell.at(time)
    }

    /// The strain rates along the axes at `time`.
    pub fn rates(&self, time: f64) -> DVec3 {
        self.cell.rates(time)
    }
}

impl ForceField for Strain {
    fn load(&self, bodies: &Bodies, i: usize, time: f64) -> Load {
        let (shape, q, rates) = (&bodies.shape[i], bodies.orientation[i], self.rates(time));
        let back = q.conjugate();
        // D_yz, D_zx and D_xy of the body's axes.
        let strain =
            [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(rates.to_array()).fold(DVec3::ZERO, |sum, (axis, rate)| {
                let axis = back * axis;
                sum + rate * yzx(axis) * zxy(axis)
            });
        let (linear, turning) = resistances(self.drag, shape);
        let force = linear * rates * bodies.position[i];
        // Validation refuses shapes without the constants.
        let torque = turning * (q * (shape.bretherton().unwrap_or_default() * strain));
        let load = Load { force, torque };
        if self.planar { load.in_plane() } else { load }
    }
}
