//! How far forces, growth, walls and flows move a scene's bodies in a step. The default of the solver's tolerance
//! follows from this.
//!
//! The residual of a solve is a length: the error of a contact in a step. A contact force with the error `e` moves a
//! body by `dt^2 e / m` with inertia, by `dt e / (xi L)` without. The relative error of the forces is therefore the
//! residual over the displacement that the load alone would cause in a step.

use super::{Body, Scene, Wall};
use crate::dynamics::Flow;
use crate::shape::Shape;
use glam::DVec3;

impl Scene {
    /// The smallest displacement of a starting body in a step by any one force, moving wall, growth, flow or changing
    /// cell alone, a length; none if nothing drives the scene. Heat, bonds and initial velocities do not count:
    /// contacts at rest do not balance them.
    pub(super) fn least_drive(&self) -> Option<f64> {
        let forces = self.ways_of_forces().into_iter().map(|(_, way, _)| way);
        let ways = forces.chain(self.ways_of_walls()).chain(self.ways_of_growth());
        let thinnest = self.thinnest();
        let ways = ways.chain(self.rates_of_strain().map(|rate| self.time.dt * rate * thinnest));
        ways.filter(|way| *way > 0.0 && way.is_finite()).reduce(f64::min)
    }

    /// The force that alone moves a starting body farthest in a step, with this displacement in thicknesses of the
    /// body; none without forces. Traps do not count: validation refuses those that are too stiff.
    pub(super) fn farthest_drive(&self) -> Option<(usize, f64)> {
        let ways = self.ways_of_forces().into_iter().filter(|(force, ..)| !self.forces[*force].is_trap());
        ways.map(|(force, way, shape)| (force, way / shape.thickness())).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The bond between listed bodies that moves one of them farthest in the first step, with this displacement in
    /// thicknesses of the body. Fixed bodies do not move, and implicit bonds do not pull too far.
    pub(super) fn farthest_bond(&self) -> Option<(usize, f64)> {
        let periods = self.periods();
        let holds = |name: &String| self.groups.get(name).is_some_and(|group| group.fixed);
        let is_fixed = |of: &Body| of.fixed || of.group.as_ref().is_some_and(holds);
        let bonds = self.bonds();
        let explicit = self.bonds.iter().enumerate().filter(|(i, _)| !bonds.is_implicit(*i));
        let ways = explicit.filter_map(|(i, bond)| {
            let [a, b] = [self.bodies.get(bond.bodies[0])?, self.bodies.get(bond.bodies[1])?];
            let end = |body: &Body, at: [f64; 3]| DVec3::from(body.position) + body.rotation() * DVec3::from(at);
            let span = periods.nearest(end(b, bond.at[1]) - end(a, bond.at[0])).length();
            let force = bond.stiffness * (span - bond.length).abs();
            let way = |of: &&Body| force * self.dynamics.yields(&of.shape, self.time.dt).0 / of.shape.thickness();
            Some((i, [a, b].iter().filter(|of| !is_fixed(of)).map(way).fold(0.0, f64::max)))
        });
        ways.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The largest displacement of a body by heat in a step, in thicknesses: the root mean square along an axis. An
    /// upper bound with inertia.
    pub(super) fn farthest_heat(&self) -> Option<f64> {
        let energy = self.thermal?.temperature;
        let way =
            |shape: Shape| (2.0 * energy * self.dynamics.yields(&shape, self.time.dt).0).sqrt() / shape.thickness();
        self.shapes().map(|(_, _, shape)| way(shape)).max_by(f64::total_cmp)
    }

    /// The shapes of the starting bodies, each with its group.
    fn shapes_of_groups(&self) -> Vec<(Option<&str>, Shape)> {
        let bodies = self.bodies.iter().map(|body| (body.group.as_deref(), body.shape));
        let moving = self.generated().filter(|(i, _)| !self.generate[*i].is_fixed());
        bodies.chain(moving.map(|(_, (_, shape, group))| (group, shape))).collect()
    }

    /// For each force and each shape that it acts on: the index of the force, the displacement of the body in a step,
    /// and the shape.
    fn ways_of_forces(&self) -> Vec<(usize, f64, Shape)> {
        let shapes = self.shapes_of_groups();
        let mut ways = Vec::new();
        for (number, force) in self.forces.iter().enumerate() {
            let acts = |group: Option<&str>| force.group().is_none_or(|of| Some(of) == group);
            let moved = shapes.iter().filter(|(group, _)| acts(*group));
            ways.extend(moved.map(|(_, shape)| {
                let way = force.magnitude(&self.dynamics, shape) * self.dynamics.yields(shape, self.time.dt).0;
                (number, way, *shape)
            }));
        }
        ways
    }

    fn ways_of_walls(&self) -> impl Iterator<Item = f64> + '_ {
        let motions = self.walls.iter().filter_map(Wall::motion);
        let moved = motions.map(|motion| self.time.dt * DVec3::from(motion.velocity).length());
        moved.chain(self.walls().ways_of_loads(self.time.dt))
    }

    /// The wall that moves farthest in a step, with this displacement in thicknesses of the thinnest body.
    pub(super) fn farthest_wall(&self) -> Option<(usize, f64)> {
        let moving = self.walls.iter().enumerate().filter_map(|(i, wall)| Some((i, wall.motion()?)));
        let ways =
            moving.map(|(i, motion)| (i, self.time.dt * DVec3::from(motion.velocity).length() / self.thinnest()));
        ways.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The largest strain in a step of the background flow and of the cell; zero without either.
    pub(super) fn largest_strain(&self) -> f64 {
        self.time.dt * self.rates_of_strain().fold(0.0, f64::max)
    }

    /// The largest relative growth of a cell in a step; zero if none grows.
    pub(super) fn largest_growth(&self) -> f64 {
        self.time.dt * self.growing().map(|(_, _, _, growth, _)| growth.rate).fold(0.0, f64::max)
    }

    fn ways_of_growth(&self) -> impl Iterator<Item = f64> + '_ {
        self.growing()
            .map(|(_, _, shape, growth, _)| self.time.dt * growth.rate * shape.growing_length().unwrap_or(0.0))
    }

    /// The strain rates of the background flow and of the cell.
    fn rates_of_strain(&self) -> impl Iterator<Item = f64> + '_ {
        let flow = self.flow.iter().map(|Flow::Shear { rate, .. }| rate.abs());
        let cell = self.periodic.iter().flat_map(|cell| {
            let strained = cell.strain_rate.unwrap_or_default().map(f64::abs);
            strained.into_iter().chain(cell.shear.map(|shear| shear.rate.abs()))
        });
        flow.chain(cell)
    }
}
