//! What a step, or a piece of one, starts from: `C^k` with the bodies and the lengths of this step, and its middle.

use super::loaded::LoadedWall;
use super::setup::Setup;
use crate::bodies::Bodies;
use crate::dynamics::bonds::daughters::bonds_of;
use crate::dynamics::{Bonds, Incidence, Pose, Waiting};
use crate::periodic::Periods;
use crate::separation::{Placed, Separation};
use crate::shape::ProxySphere;
use crate::step::{Fault, Piece, Shake, State};
use crate::walls::Walls;
use crate::warm::Warm;
use glam::DVec3;

pub struct Start {
    /// The piece of the step, and the cells that wait in it.
    pub(super) piece: Piece,
    waiting: Waiting,
    /// Whether overlapping bodies are being separated without advancing time.
    pub(super) parting: bool,
    /// Whether contacts do without the scene's restitution.
    pub(super) without_restitution: bool,
    /// The draw that moves bodies while they are parted, if there is one.
    pub(super) shake: Option<Shake>,
    /// When the piece begins.
    pub(super) time: f64,
    /// The length of the part of the step that is being computed.
    pub(super) interval: f64,
    /// `C^k` with the bodies of this step and the lengths at the end of the part.
    pub(super) bodies: Bodies,
    /// The periods of space at the end of the part.
    pub(super) periods: Periods,
    /// The next free id.
    pub(super) next_id: u64,
    /// `C_h` with the lengths there, once it is known.
    pub(super) middle: Option<Bodies>,
    /// Each body's sub-spheres; empty where rows are of surfaces.
    pub(super) proxies: Vec<Vec<ProxySphere>>,
    /// Which bonds hold which bodies, for those that are explicit; none where there are no bonds, or bodies are parted.
    pub(super) bonds: Option<Incidence>,
    /// The implicit bonds that act, with their bodies.
    pub(super) held_bonds: Vec<(usize, [usize; 2])>,
    /// The pairs that bonds keep from colliding, the lower row first, ascending.
    without_contact: Vec<[u32; 2]>,
    /// The bonds of daughters, which are numbered after the scene's.
    daughters: Bonds,
    /// Whether first rows of these may be made where the last velocities lead.
    pub(super) leads: bool,
    /// Moving walls: at the piece's start, at the end of the present part, and at its middle once that is known.
    pub(super) walls: Option<[Walls; 3]>,
    /// The walls under a load.
    pub(super) loaded: Vec<LoadedWall>,
    /// The rates at which the lengths of a cell that changes do so; none where bodies are parted.
    strained: Option<DVec3>,
    /// Flags of fixed bodies; empty if there are none.
    held: Vec<bool>,
    /// By how much bodies grow in the present part, in a scene with friction; else empty.
    pub(super) lengthened: Vec<f64>,
    /// What slows the growth of this step's bodies; may be empty.
    pub(super) slowing: Vec<f64>,
    /// Flags of bodies that belong to other processes; empty on one process.
    pub(super) foreign: Vec<bool>,
}

impl Setup {
    /// Lets the forces that act in this part of step `step` see the state there.
    pub(super) fn prepare(&self, start: &Start, step: u64) -> Result<(), Fault> {
        let (_, forces) = self.law(start.parting);
        let acting = forces.iter().filter(|force| force.share(start.span()) > 0.0);
        acting.into_iter().try_for_each(|force| {
            force.prepare(start.bodies_at_loads(), start.time_of_loads()).map_err(|what| Fault::Force { step, what })
        })
    }
}

impl Start {
    pub(super) fn new(interval: f64, next_id: u64) -> Start {
        Start {
            piece: Piece::WHOLE,
            waiting: Waiting::None,
            parting: false,
            without_restitution: false,
            shake: None,
            time: 0.0,
            interval,
            bodies: Bodies::default(),
            periods: Periods::NONE,
            next_id,
            middle: None,
            proxies: Vec::new(),
            bonds: None,
            held_bonds: Vec::new(),
            without_contact: Vec::new(),
            daughters: Bonds::default(),
            leads: false,
            walls: None,
            loaded: Vec::new(),
            strained: None,
            held: Vec::new(),
            lengthened: Vec::new(),
            slowing: Vec::new(),
            foreign: Vec::new(),
        }
    }

    /// Whether body `i` does not move.
    pub(super) fn is_held(&self, i: usize) -> bool {
        self.held.get(i).copied().unwrap_or(false)
    }

    /// Whether two bodies, the lower row first, do not collide: both are fixed, or a bond keeps them from it.
    pub(super) fn never_collide(&self, a: usize, b: usize) -> bool {
        self.is_held(a) && self.is_held(b) || {
            let pair = [a as u32, b as u32];
            !self.without_contact.is_empty() && self.without_contact.binary_search(&pair).is_ok()
        }
    }

    /// The pairs that bonds keep from colliding.
    pub(super) fn without_contact(&self) -> &[[u32; 2]] {
        &self.without_contact
    }

    /// Whether body `i` is another process's.
    pub(super) fn is_foreign(&self, i: usize) -> bool {
        self.foreign.get(i).copied().unwrap_or(false)
    }

    /// Whether body `i` is skipped in searches for its own contacts: it is fixed, or another process's.
    pub(super) fn is_idle(&self, i: usize) -> bool {
        self.is_held(i) || self.is_foreign(i)
    }

    /// Begins this piece of the next step with the bodies of `state` and computes what slows their growth; `warm` is
    /// the warm start of their pairs.
    pub(super) fn begin(&mut self, setup: &Setup, state: &State, warm: &[Warm], (piece, waiting): (Piece, Waiting)) {
        (self.piece, self.waiting) = (piece, waiting);
        self.time = setup.time.after(state.step) + piece.start * piece.span * setup.time.dt;
        let length = self.piece_length(setup);
        self.interval = if setup.is_midpoint() { 0.5 * length } else { length };
        self.bodies.clone_from(&state.bodies);
        self.next_id = state.next_id;
        self.middle = None;
        if let Some(growth) = setup.growth.as_ref().filter(|_| !self.parting) {
            self.slowing = growth.slowing(&state.bodies, warm, &state.fields);
        }
        self.foreign.clear();
        self.place_walls(setup);
        self.place_cell(setup);
    }

    /// Begins the step after `steps` steps with the bodies that a device has: those of the step, which have grown by
    /// the numbers in `lengthened`.
    #[cfg(feature = "gpu")]
    pub(super) fn begin_on_device(
        &mut self,
        setup: &Setup,
        steps: u64,
        bodies: Bodies,
        lengthened: Vec<f64>,
    ) -> Result<(), Fault> {
        self.time = setup.time.after(steps);
        self.interval = self.piece_length(setup);
        (self.bodies, self.lengthened) = (bodies, lengthened);
        self.place_walls(setup);
        self.place_cell(setup);
        self.settle(setup)?;
        self.hold(setup, true);
        Ok(())
    }

    /// Divides the cells that are due and returns the mothers.
    pub(super) fn divide(&mut self, setup: &Setup) -> Vec<usize> {
        let Some(growth) = setup.growth.as_ref().filter(|_| !self.parting) else { return Vec::new() };
        growth.divide(
            &mut self.bodies,
            (self.time, self.piece.turn),
            &mut self.next_id,
            &mut self.slowing,
            &self.waiting,
        )
    }

    /// Grows all cells over the first part of the step.
    pub(super) fn grow(&mut self, setup: &Setup) {
        self.lengthened.clear();
        if let Some(growth) = setup.growth.as_ref().filter(|_| !self.parting) {
            let lengths = |bodies: &Bodies| -> Vec<f64> {
                bodies.shape.iter().map(|shape| shape.growing_length().unwrap_or_default()).collect()
            };
            let before = if setup.friction.is_none() { Vec::new() } else { lengths(&self.bodies) };
            growth.lengthen(&mut self.bodies, self.interval, &self.slowing, &self.waiting);
            if !before.is_empty() {
                self.lengthened.extend(lengths(&self.bodies).iter().zip(&before).map(|(now, before)| now - before));
            }
        }
    }

    /// Prepares bonds, flags and proxies of this step's bodies.
    pub(super) fn settle(&mut self, setup: &Setup) -> Result<(), Fault> {
        let bonded = !setup.bonds.is_empty() && !self.parting;
        self.bonds = bonded.then(|| setup.bonds.incidence(&self.bodies.lineage, &self.bodies.broken_bonds));
        self.held = setup.fixed.flags(&self.bodies);
        if setup.bonds.any_without_contact() {
            let incidence = setup.bonds.incidence(&self.bodies.lineage, &self.bodies.broken_bonds);
            self.without_contact = setup.bonds.without_contact(&incidence);
        }
        let cells = setup.growth.as_ref().filter(|cells| cells.bond_daughters());
        self.daughters = cells.map_or_else(Bonds::default, |cells| bonds_of(&self.bodies, cells));
        self.make_proxies(setup)
    }

    /// The bonds that a bond is one of, and its number there.
    pub(super) fn bonds_with<'a>(&'a self, setup: &'a Setup, bond: usize) -> (&'a Bonds, usize) {
        let of_scene = setup.bonds.list().len();
        if bond < of_scene { (&setup.bonds, bond) } else { (&self.daughters, bond - of_scene) }
    }

    /// The bonds of daughters.
    pub(super) fn daughters(&self) -> &Bonds {
        &self.daughters
    }

    /// The implicit bonds that act: the scene's, then those of daughters.
    pub(super) fn acting_bonds(&self, setup: &Setup) -> Vec<(usize, [usize; 2])> {
        let mut acting = setup.bonds.implicit(&self.bodies, self.parting);
        let first = setup.bonds.list().len();
        let of_daughters = self.daughters.list().iter().enumerate();
        let acts = |bond: usize| !self.parting || self.daughters.keeps_something(bond);
        acting.extend(of_daughters.filter(|(bond, _)| acts(*bond)).map(|(number, bond)| (first + number, bond.bodies)));
        acting
    }

    /// Sets the configuration at the middle, and the lengths at the end.
    pub(super) fn set_middle(&mut self, setup: &Setup, middle: Bodies) {
        self.middle = Some(middle);
        self.interval = self.piece_length(setup);
        self.place_walls(setup);
        if let Some(growth) = &setup.growth {
            growth.lengthen(&mut self.bodies, 0.5 * self.interval, &self.slowing, &self.waiting);
        }
    }

    /// Moves the walls. Parting bodies takes no time.
    fn place_walls(&mut self, setup: &Setup) {
        let interval = if self.parting { 0.0 } else { self.interval };
        let times = [0.0, 1.0, 0.5].map(|part| self.time + part * interval);
        self.walls = setup.walls.move_in_time().then(|| times.map(|time| setup.walls.at(time)));
        self.load_walls(setup);
    }

    /// Sets the periods at the end of the present part.
    fn place_cell(&mut self, setup: &Setup) {
        self.strained = setup.strain.filter(|_| !self.parting).map(|strain| strain.rates(self.time));
        self.periods = match &setup.strain {
            Some(strain) if !self.parting => strain.periods(self.time + self.interval),
            Some(strain) => strain.periods(self.time),
            None => self.bodies.periods,
        };
    }

    /// A separation that was found where the flow of a changing cell leads, at the start.
    pub(super) fn separation_before(&self, setup: &Setup, [a, b]: [DVec3; 2], found: &Separation) -> f64 {
        let (Some(rates), Some(strain)) = (self.strained, &setup.strain) else { return found.separation };
        let apart = self.periods.nearest(b - a);
        let moved = match strain.shear() {
            Some(shear) => self.interval * shear.velocity(apart),
            None => {
                let strained = self.interval * rates;
                apart * strained / (DVec3::ONE + strained)
            }
        };
        found.separation - found.normal.dot(moved)
    }

    /// The velocity of the image of `b` nearest to `a`, relative to `b`, in a sheared cell.
    pub(super) fn sheared_velocity(&self, setup: &Setup, a: usize, b: usize) -> DVec3 {
        let Some(shear) = setup.strain.and_then(|strain| strain.shear()) else { return DVec3::ZERO };
        shear.velocity(self.image_shift(a, b))
    }

    /// The same in any cell that changes.
    pub(super) fn image_velocity(&self, setup: &Setup, a: usize, b: usize) -> DVec3 {
        let Some(strain) = setup.strain else { return DVec3::ZERO };
        strain.velocity(self.image_shift(a, b), self.strained.unwrap_or_default())
    }

    /// From `b` to its image nearest to `a`.
    fn image_shift(&self, a: usize, b: usize) -> DVec3 {
        let apart = self.bodies.position[b] - self.bodies.position[a];
        self.bodies.periods.nearest(apart) - apart
    }

    /// The walls at the end of the present part, which bodies must not overlap.
    pub(super) fn walls<'a>(&'a self, setup: &'a Setup) -> &'a Walls {
        self.walls.as_ref().map_or(&setup.walls, |[_, end, _]| end)
    }

    /// Moving walls at the piece's start.
    pub(super) fn walls_before(&self) -> Option<&Walls> {
        self.walls.as_ref().map(|[start, ..]| start)
    }

    /// Moving walls at the middle, once that is known.
    pub(super) fn walls_in_middle(&self) -> Option<&Walls> {
        self.walls.as_ref().filter(|_| self.middle.is_some()).map(|[.., middle]| middle)
    }

    pub(super) fn make_proxies(&mut self, setup: &Setup) -> Result<(), Fault> {
        self.proxies = setup.source.proxies(&self.bodies.shape).map_err(Fault::NoProxy)?;
        Ok(())
    }

    /// The length of the whole step that the piece is of.
    pub(super) fn step_length(&self, setup: &Setup) -> f64 {
        self.piece.span * setup.time.dt
    }

    fn piece_length(&self, setup: &Setup) -> f64 {
        self.piece.length * self.piece.span * setup.time.dt
    }

    /// When the part that is being computed begins and ends.
    pub(super) fn span(&self) -> [f64; 2] {
        [self.time, self.time + self.interval]
    }

    /// The time at which forces are evaluated: the start, or the middle once it is known.
    pub(super) fn time_of_loads(&self) -> f64 {
        self.time + if self.middle.is_some() { 0.5 * self.interval } else { 0.0 }
    }

    /// The bodies at which forces, mobilities and first rows are evaluated: the middle once it is known, else the
    /// start.
    pub(super) fn bodies_at_loads(&self) -> &Bodies {
        self.middle.as_ref().unwrap_or(&self.bodies)
    }

    /// The axis of body `i` where forces act, at the start or in the middle, if it is a body of revolution.
    pub(super) fn axis_of_revolution(&self, i: usize) -> Option<DVec3> {
        Some(self.bodies_at_loads().orientation[i] * self.bodies_at_loads().shape[i].axis_of_revolution()?)
    }

    pub(super) fn pose(&self, i: usize) -> Pose {
        Pose { position: self.bodies.position[i], orientation: self.bodies.orientation[i] }
    }

    /// Body `i` with its shape at the end of the part, in another pose.
    pub(super) fn placed_at(&self, i: usize, Pose { position, orientation }: Pose) -> Placed {
        Placed { shape: self.bodies.shape[i], position, orientation }
    }
}
