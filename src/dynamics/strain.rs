//! The flow of a periodic cell whose lengths change: `u_i = e_i(t) x_i`, with the strain rates `e_i = r_i / (1 + r_i
//! t)` of lengths `h_i = h_i(0) (1 + r_i t)` (the engineering strain rates `r_i` are those of LAMMPS' `fix deform ...
//! erate`).
//!
//! It carries bodies as any flow does, by drag: those of the overdamped law go with the cell, and turn with the strain
//! about each axis as Jeffery's equation says (`flow.rs`). Images of a body are carried like it, as the cell's sides
//! go with the same flow. An Euler step from `t` takes an undisturbed body by `dt e_i(t) x_i`, and the cell by the same
//! part of its length, exactly.
//!
//! That of a sheared cell is steady simple shear, `u = g x_e d`. Its load is that of a background flow (`flow.rs`), so
//! this file has only the displacement. A law without drag has no flow: bodies keep their velocities, and rows are made
//! in the same way.

use super::along::Along;
use super::flow::{yzx, zxy};
use super::{Drag, Dynamics, ForceField, Load};
use crate::bodies::Bodies;
use crate::periodic::{CellShear, Periodic, Periods};
use glam::DVec3;

/// The flow of a scene's cell and the resistance to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    cell: Periodic,
    /// The law's drag, under a law with drag.
    drag: Option<Drag>,
    /// Whether bodies move in the x-y plane.
    planar: bool,
}

impl Strain {
    /// That of a cell that is sheared, or whose lengths change under a law that has drag; none of another.
    pub fn new(cell: &Periodic, dynamics: &Dynamics, planar: bool) -> Option<Strain> {
        let drag = dynamics.any_drag();
        let changes = cell.shear.is_some() || (cell.strain_rate.is_some() && drag.is_some());
        changes.then_some(Strain { cell: *cell, drag, planar })
    }

    /// The shear of a sheared cell.
    pub fn shear(&self) -> Option<CellShear> {
        self.cell.shear
    }

    /// Whether a length of the cell shrinks.
    pub fn shrinks(&self) -> bool {
        self.cell.strain_rate.is_some_and(|rates| rates.iter().any(|rate| *rate < 0.0))
    }

    /// The velocity of the flow at a place, where the lengths change at these rates.
    pub fn velocity(&self, x: DVec3, rates: DVec3) -> DVec3 {
        self.cell.shear.map_or(rates * x, |shear| shear.velocity(x))
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
        let Some(drag) = self.drag else { return Load::default() };
        let resistance = drag.resistance(shape);
        let force = match resistance.linear {
            Along::Even(linear) => linear * rates * bodies.position[i],
            axes => axes.of(q, rates * bodies.position[i]),
        };
        // Validation refuses shapes without the constants.
        let torque = resistance.turning.of(q, q * (drag.bretherton(shape).unwrap_or_default() * strain));
        let load = Load { force, torque };
        if self.planar { load.in_plane() } else { load }
    }
}
