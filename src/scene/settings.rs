//! What a scene's settings mean to a step and to a recorder, with the defaults that depend on other settings.

use super::generate::bonds_of_chain;
use super::{
    Body, Bond, ContactSettings, Dump, Generate, GrowingShape, Growth, Joint, Recursion, Rows, SMALLEST_NUMBER, Scene,
    Stop, unit_quaternion,
};
use crate::bodies::{Bodies, HeldBond};
use crate::constraint::friction::Coefficients;
use crate::dynamics::bonds::daughters::held_daughters;
use crate::dynamics::{Bonds, Cells, Heat, Strain, Stream, draw};
use crate::fields::Fields;
use crate::fixed::Fixed;
use crate::gpu::Precision;
use crate::lcp::Settings;
use crate::periodic::Periods;
use crate::removal::Removals;
use crate::shape::Shape;
use crate::step::Model;
use crate::walls::Walls;
use glam::DQuat;
use std::collections::BTreeMap;
use std::iter::repeat_n;

/// A solver stops at this part of the overlap tolerance, so that its error adds little to the overlaps that the
/// recursion measures.
const TOLERANCE_PER_OVERLAP: f64 = 0.1;

/// And at this part of the displacement that drives cause in a step, so that contact forces have about this relative
/// error.
const TOLERANCE_PER_DRIVE: f64 = 1e-3;

/// But not below this part of the overlap tolerance: rounding errors of separations are larger.
const LEAST_PER_OVERLAP: f64 = 1e-8;

/// The default solver solves every LCP of the built-in scenes in fewer iterations; a solve that reaches this many has
/// stalled.
const MOST_ITERATIONS: u64 = 100_000;

/// The default elastic slip in solver tolerances. A pile of ten spheres at rest moves by 5e-5 of a radius in 5,000
/// steps with 100, and by 2e-5 with 300. A prototype's pile moved ever more with 30, and collapsed with 10: gaps that
/// solves leave open unload contacts.
const SLIP_PER_TOLERANCE: f64 = 100.0;

/// The default number of recorded states of a run: a movie of some seconds.
const STATES: f64 = 100.0;

impl Scene {
    /// When the LCP solver stops: as given, or by default after 100,000 iterations, and at the smaller of a tenth of
    /// the overlap tolerance and a thousandth of what forces, growth or walls move a body by in a step.
    ///
    /// ```
    /// let mut scene = relcp::Scene::new("none", relcp::scene::Time::new(0.1, 1.0));
    /// scene.solver.max_iterations = Some(5);
    /// let settings = scene.lcp_settings();
    /// assert_eq!((settings.tolerance, settings.max_iterations), (0.1 * scene.contact.overlap_tolerance, 5));
    /// ```
    pub fn lcp_settings(&self) -> Settings {
        Settings {
            tolerance: self.solver_tolerance(Precision::F64),
            max_iterations: self.solver.max_iterations.unwrap_or(MOST_ITERATIONS),
        }
    }

    /// The stopping criteria of the LCP solver in this precision. By default f32 uses a tenth of the overlap tolerance:
    /// it cannot resolve what a small step requires.
    pub(crate) fn solver_tolerance(&self, precision: Precision) -> f64 {
        let overlap = self.contact.overlap_tolerance;
        let default = match precision {
            Precision::F32 => TOLERANCE_PER_OVERLAP * overlap,
            Precision::F64 => {
                let driven = TOLERANCE_PER_DRIVE * self.least_drive().unwrap_or(f64::INFINITY);
                (TOLERANCE_PER_OVERLAP * overlap).min(driven.max(LEAST_PER_OVERLAP * overlap))
            }
        };
        // Not below the smallest number of a scene, so that the scene that is written can be read.
        self.solver.tolerance.unwrap_or(default.max(SMALLEST_NUMBER))
    }

    /// Distance within which pairs are near at a step's start: as given, or a tenth of the thinnest starting body's
    /// thickness.
    pub fn cutoff(&self) -> f64 {
        self.contact.cutoff_of(self.shapes().map(|(_, _, shape)| shape))
    }

    /// As [`Scene::cutoff`], for bodies of these shapes instead of the scene's.
    pub fn cutoff_of(&self, shapes: impl Iterator<Item = Shape>) -> f64 {
        if self.grows_ellipsoids() { self.cutoff() } else { self.contact.cutoff_of(shapes) }
    }

    /// Whether ellipsoids grow. They become thinner when they divide; their cutoff stays that of the start.
    fn grows_ellipsoids(&self) -> bool {
        self.growth.iter().any(|growth| growth.shape == GrowingShape::Ellipsoid)
    }

    /// The least thickness that a body may have in the run, where ellipsoids grow.
    fn thinnest_ever(&self) -> Option<f64> {
        let born = self.growing().map(|(_, _, shape, growth, _)| growth.shortest(&shape).thickness());
        self.grows_ellipsoids().then(|| born.fold(self.thinnest(), f64::min))
    }

    /// The thinnest starting body's thickness; infinite without bodies.
    pub(crate) fn thinnest(&self) -> f64 {
        self.shapes().map(|(_, _, shape)| shape.thickness()).fold(f64::INFINITY, f64::min)
    }

    /// Time between recorded states: as given, or a hundredth of the run. `None` if the run has no duration.
    pub fn output_every(&self) -> Option<f64> {
        let duration = self.time.end - self.time.start;
        self.output.every.or((duration > 0.0).then_some((duration / STATES).max(SMALLEST_NUMBER)))
    }

    /// This scene with every default that depends on other keys written out.
    pub fn with_defaults(&self) -> Scene {
        let mut scene = self.clone();
        let Settings { tolerance, max_iterations } = self.lcp_settings();
        scene.contact.recursion = self.recursion();
        scene.solver.tolerance = Some(tolerance);
        scene.solver.max_iterations = Some(max_iterations);
        scene.solver.dump = self.solver.dump.map(Dump::with_defaults);
        scene.contact.cutoff = Some(self.cutoff());
        if !self.friction().is_none() {
            scene.contact.elastic_slip = Some(self.elastic_slip());
        }
        scene.output.every = self.output_every();
        scene.write_orientations();
        scene
    }
}

#[cfg(feature = "files")]
fn follow<T: PartialEq>(now: &mut Option<T>, before: Option<T>, default: Option<T>) {
    if *now == before && before == default {
        *now = None;
    }
}

impl Scene {
    /// Drops defaults that [`Scene::with_defaults`] has written into `before`, where this scene still has them: they
    /// follow its other keys again.
    #[cfg(feature = "files")]
    pub(crate) fn follow_defaults(&mut self, before: &Scene) {
        let mut bare = before.clone();
        (bare.solver.tolerance, bare.solver.max_iterations) = (None, None);
        (bare.contact.recursion, bare.contact.cutoff, bare.contact.elastic_slip) = (Recursion::Auto, None, None);
        let full = bare.with_defaults();
        let (contact, solver) = (&mut self.contact, &mut self.solver);
        // A value that is the default, and is still that of before.
        follow(&mut solver.tolerance, before.solver.tolerance, full.solver.tolerance);
        follow(&mut solver.max_iterations, before.solver.max_iterations, full.solver.max_iterations);
        follow(&mut contact.cutoff, before.contact.cutoff, full.contact.cutoff);
        follow(&mut contact.elastic_slip, before.contact.elastic_slip, full.contact.elastic_slip);
        if contact.recursion == before.contact.recursion && before.contact.recursion == full.contact.recursion {
            contact.recursion = Recursion::Auto;
        }
    }

    /// How tightly the solves before a step's last one are made: exactly or inexactly.
    pub fn recursion(&self) -> Recursion {
        match self.contact.recursion {
            Recursion::Auto => {
                let may_loosen = self.contact.rows_of_method() == Rows::Auto && self.solver.tolerance.is_none();
                let open = self.walls.is_empty() && self.periodic.is_none();
                let colony = !self.growth.is_empty() && open && self.friction().is_none();
                match self.planar {
                    false if may_loosen => Recursion::Inexact,
                    true if may_loosen && colony => Recursion::Adaptive,
                    _ => Recursion::Exact,
                }
            }
            given => given,
        }
    }
}

impl Scene {
    /// The surfaces of all walls at the scene's start. [`Walls::at`] gives those at another time.
    pub fn walls(&self) -> Walls {
        Walls::in_space(&self.walls, self.planar, &self.periods()).at(self.time.start)
    }

    /// The periods of space at the scene's start.
    pub fn periods(&self) -> Periods {
        self.periodic.map_or(Periods::NONE, |periodic| periodic.at(self.time.start))
    }

    /// The condition that ends the run before `time.end`, if any.
    pub fn stop(&self) -> Option<Stop> {
        self.growth.iter().find_map(|growth| growth.stop)
    }

    /// An estimate of the number of bodies at the end of the run. Without pressure or other delays, cells that divide
    /// at a length multiply by e in the reciprocal of their rate.
    pub fn bodies_at_end(&self) -> f64 {
        #[cfg(feature = "files")]
        let generated = self.generate.iter().map(|rule| rule.count()).sum::<u64>();
        #[cfg(not(feature = "files"))]
        let generated = 0;
        let all_bodies = generated as f64 + self.bodies.len() as f64;
        let fastest = self.growth.iter().map(|growth| growth.rate).fold(0.0, f64::max);
        let stop = self.stop().and_then(|stop| stop.population).map_or(f64::INFINITY, |most| most as f64);
        (all_bodies * (fastest * (self.time.end - self.time.start)).exp()).min(stop.max(all_bodies))
    }

    /// The growth of the bodies of a group, or of those without; none if they do not grow.
    pub fn growth_of(&self, group: Option<&str>) -> Option<&Growth> {
        let own = self.growth.iter().find(|growth| growth.group.as_deref() == group);
        own.or_else(|| self.growth.iter().find(|growth| growth.group.is_none()))
    }

    /// The seed of the random numbers of each step, with the step's number. It depends on the scene's start time, so
    /// that a run from another's `final.json` does not repeat its numbers.
    fn seed_of_steps(&self) -> u64 {
        if self.time.start == 0.0 {
            return self.seed;
        }
        let [low, high] = draw::halves(self.time.start.to_bits());
        let [low, high, ..] = draw::philox([low, high, 0, 0], draw::halves(self.seed));
        u64::from(low) | u64::from(high) << 32
    }

    /// The growth and the length of a body of this group and shape, if it grows.
    pub(crate) fn growth_of_body(&self, group: Option<&str>, shape: &Shape) -> Option<(&Growth, f64)> {
        let growth = self.growth_of(group)?;
        Some((growth, growth.length_of(shape)?))
    }

    /// How cells grow, if any do.
    #[doc(hidden)]
    pub fn cells(&self) -> Option<Cells> {
        let grows = !self.growth.is_empty();
        grows.then(|| {
            let cells = Cells::new(&self.growth, &self.group_names(), self.planar, self.seed);
            cells.with_fields(self.fields())
        })
    }

    /// The fields, as steps take them on.
    pub(crate) fn fields(&self) -> Fields {
        let periodic = self.periodic.map_or([false; 3], |cell| cell.lengths.map(|length| length.is_some()));
        let fields = Fields::new(&self.fields, &self.group_names(), periodic, self.planar);
        fields.with_ellipsoids_along(self.grows_ellipsoids())
    }

    /// How bodies are removed, if any are.
    #[doc(hidden)]
    pub fn removals(&self) -> Option<Removals> {
        let fixed = self.fixed();
        let removals = Removals::new(&self.removal, &self.group_names(), self.planar, self.seed_of_steps(), fixed);
        (!removals.is_empty()).then_some(removals)
    }

    /// The random loads, if the scene has any.
    fn heat(&self) -> Option<Heat> {
        let (seed, dynamics, planar) = (self.seed_of_steps(), self.dynamics, self.planar);
        self.thermal.map(|thermal| Heat { thermal, seed, dynamics, planar })
    }

    /// The bonds and joints, by the ids of their bodies.
    pub(crate) fn bonds(&self) -> Bonds {
        let all = self.all_bonds();
        let bodies = all.iter().map(|bond| bond.bodies).chain(self.joints.iter().map(Joint::bodies));
        let held = bodies.flatten().max().map_or(0, |last| last.saturating_add(1));
        let ids: Vec<u64> = self.ids().take(held).collect();
        let joints = self.joints.iter().map(|joint| (*joint, self.rest_of(joint))).collect();
        let bonds = Bonds::new(&all, |body| ids[body]).with_joints(joints, self.planar, |body| ids[body]);
        if self.makes_bonds_implicit() { bonds.with_open_ones_implicit() } else { bonds }
    }

    /// The bonds and joints of bodies, as a state has them that no step has led to.
    pub(crate) fn held_bonds(&self, bodies: &Bodies) -> Vec<HeldBond> {
        if self.all_bonds().is_empty()
            && self.joints.is_empty()
            && !self.growth.iter().any(|of| of.bond_daughters.is_some())
        {
            return Vec::new();
        }
        let bonds = self.bonds();
        let mut held = bonds.held(bodies, &BTreeMap::new());
        if let Some(cells) = self.cells().filter(Cells::bond_daughters) {
            held.extend(held_daughters(bodies, &cells, bonds.list().len()));
        }
        held
    }

    /// The orientation of the second body of a joint in the axes of the first one at rest: as given, or as both start.
    fn rest_of(&self, joint: &Joint) -> DQuat {
        if let Some(Some(rest)) = joint.rest() {
            return unit_quaternion(rest);
        }
        let [a, b] = joint.bodies().map(|body| self.bodies.get(body).map_or(DQuat::IDENTITY, Body::rotation));
        (a.inverse() * b).normalize()
    }

    /// The bonds of `bonds`, then those of the chains that `generate` places, in order.
    pub fn all_bonds(&self) -> Vec<Bond> {
        let mut all = self.bonds.clone();
        let mut first = self.bodies.len();
        for rule in &self.generate {
            if let Generate::Chain(chain) = rule {
                all.extend(bonds_of_chain(chain, first));
            }
            first += rule.count() as usize;
        }
        all
    }

    /// The bodies that do not move.
    #[doc(hidden)]
    pub fn fixed(&self) -> Fixed {
        let of_group = |name: &String| self.groups.get(name).is_some_and(|group| group.fixed);
        let given = self.bodies.iter().map(|body| body.fixed);
        let rules = self.generate.iter().flat_map(|rule| repeat_n(rule.is_fixed(), rule.count() as usize));
        let any = self.generate.iter().any(Generate::is_fixed);
        let flags = given.chain(rules.take(if any { usize::MAX } else { 0 }));
        let ids = flags.zip(self.ids()).filter(|(fixed, _)| *fixed).map(|(_, id)| id).collect();
        Fixed::new(ids, self.group_names().iter().map(of_group).collect())
    }

    /// The flow that carries bodies: the scene's own, or that of its sheared cell.
    fn stream(&self) -> Option<Stream> {
        let own = self.flow.and_then(|flow| Stream::new(&flow, &self.dynamics, self.planar));
        let shear = self.periodic.and_then(|cell| cell.shear);
        own.or_else(|| shear.and_then(|shear| Stream::of_cell(&shear, &self.dynamics, self.planar)))
    }

    /// The coefficients of friction of all contacts.
    #[doc(hidden)]
    pub fn friction(&self) -> Coefficients {
        let walls = Walls::new(&self.walls, self.planar);
        Coefficients::new(&self.contact.friction, &self.group_names(), walls.frictions(), self.elastic_slip())
    }

    /// How far a mean contact with friction slips elastically before it slides, a length: as given, or 100 times the
    /// solver's tolerance.
    pub fn elastic_slip(&self) -> f64 {
        self.elastic_slip_in(Precision::F64)
    }

    /// The same on a device of this precision. In f32 rounding moves contacts by some 1e-7 of the size of bodies in a
    /// step, and stick must give by far more: ten balls in a pile, in steps of 1e-3, move by 6e-2, 1e-6 and 2e-6 in a
    /// time of 0.5 with 1e-6, 1e-5 and 1e-4.
    pub(crate) fn elastic_slip_in(&self, precision: Precision) -> f64 {
        self.contact.elastic_slip.unwrap_or(SLIP_PER_TOLERANCE * self.solver_tolerance(precision))
    }

    /// The model for the steps of this scene.
    #[doc(hidden)]
    pub fn model(&self) -> Model {
        let cutoff = if self.grows_ellipsoids() { Some(self.cutoff()) } else { self.contact.cutoff };
        Model {
            seed: self.seed_of_steps(),
            planar: self.planar,
            time: self.time,
            dynamics: self.dynamics,
            forces: self.forces.clone(),
            groups: self.group_names(),
            bonds: self.bonds(),
            heat: self.heat(),
            stream: self.stream(),
            strain: self.periodic.and_then(|cell| Strain::new(&cell, &self.dynamics, self.planar)),
            fixed: self.fixed(),
            walls: self.walls(),
            periods: self.periods(),
            confined: !self.walls.is_empty() || self.periodic.is_some(),
            cells: self.cells(),
            thinnest: self.thinnest_ever(),
            friction: self.friction(),
            contact: ContactSettings { recursion: self.recursion(), cutoff, ..self.contact.clone() },
            solver: self.solver.kind,
            lcp: self.lcp_settings(),
        }
    }
}
