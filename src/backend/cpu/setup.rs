//! What is constant over all steps on the CPU.

use crate::bodies::Bodies;
use crate::constraint::RowSource;
use crate::constraint::friction::{Coefficients, Restitution};
use crate::dynamics::{self, Bonds, Cells, Drag, ForceField, Heat, Law, Overdamped, Strain};
use crate::fixed::Fixed;
use crate::shape::Shape;
use crate::step::{Model, Rows, Stepping, Time};
use crate::walls::Walls;

/// The law of motion for separating bodies: long ones turn and move less easily. The drag cancels out.
const PARTING: Overdamped = Overdamped { drag: Drag::Even(1.0) };

/// A scene's law, forces, walls and tolerances, and how its rows are made.
pub struct Setup {
    pub(super) time: Time,
    pub(super) growth: Option<Cells>,
    pub(super) forces: Vec<Box<dyn ForceField>>,
    /// How many of them are the scene's; those that were added come after.
    pub(super) scene_forces: usize,
    pub(super) bonds: Bonds,
    pub(super) heat: Option<Heat>,
    pub(super) strain: Option<Strain>,
    pub(super) walls: Walls,
    pub(super) fixed: Fixed,
    pub(super) source: RowSource,
    pub(super) rows: Rows,
    pub(super) friction: Coefficients,
    pub(super) restitution: Restitution,
    pub(super) seed: u64,
    pub(super) has_inertia: bool,
    pub(super) overlap_tolerance: f64,
    pub(super) cutoff: f64,
    /// Thickness of the thinnest body.
    pub(super) thinnest: f64,
    /// Whether first rows may be made where the last velocities lead.
    pub(super) leads_ahead: bool,
    law: Box<dyn Law>,
}

impl Setup {
    pub(super) fn new(model: &Model, bodies: &Bodies) -> Setup {
        let shapes = || bodies.shape.iter();
        let mut forces = dynamics::force_fields(&model.forces, &model.groups, &model.dynamics);
        // The load of a sheared cell's flow is that of the stream.
        let strained = model.strain.filter(|strain| strain.shear().is_none());
        forces.extend(strained.map(|strain| Box::new(strain) as Box<dyn ForceField>));
        forces.extend(model.stream.map(|stream| Box::new(stream) as Box<dyn ForceField>));
        Setup {
            time: model.time,
            growth: model.cells.clone(),
            bonds: model.bonds.clone(),
            scene_forces: forces.len(),
            forces,
            heat: model.heat,
            strain: model.strain,
            walls: model.walls.clone(),
            fixed: model.fixed.clone(),
            source: model.contact.method.row_source(),
            rows: model.contact.rows_of_method(),
            friction: model.friction.clone(),
            restitution: model.contact.restitution,
            seed: model.seed,
            has_inertia: model.dynamics.has_inertia(),
            overlap_tolerance: model.contact.overlap_tolerance,
            cutoff: model.contact.cutoff_of(shapes().copied()),
            thinnest: shapes().map(Shape::thickness).fold(model.thinnest.unwrap_or(f64::INFINITY), f64::min),
            leads_ahead: leads_ahead(model),
            law: dynamics::law(&model.dynamics),
        }
    }

    pub(super) fn is_midpoint(&self) -> bool {
        self.time.stepping == Stepping::Midpoint
    }

    /// The law and the forces of a step, or of bodies that are parted in no time.
    pub(super) fn law(&self, parting: bool) -> (&dyn Law, &[Box<dyn ForceField>]) {
        if parting { (&PARTING, &[]) } else { (self.law.as_ref(), &self.forces) }
    }
}

/// Whether first rows of a scene's steps may be made ahead of their start: in Euler steps without inertia. With inertia
/// rows at the start keep the angular momentum of a pair to rounding, and rows ahead do not.
fn leads_ahead(model: &Model) -> bool {
    let inertial = model.dynamics.has_inertia();
    // Random loads leave nothing of the last velocities, and those of a changing cell depend on images.
    let steady = model.heat.is_none() && model.strain.is_none();
    model.contact.rows_of_method() == Rows::Auto && model.time.stepping == Stepping::Euler && !inertial && steady
}
