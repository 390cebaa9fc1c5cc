//! Bonds: springs between points of bodies, which may break.
//!
//! A bond of stiffness `k` and length `l` between the points `x_a` and `x_b` of two bodies pulls each point towards the
//! other with the tension `k (|d| - l)`, `d = x_b - x_a`; where it is shorter than `l` it pushes. A point is given in
//! its body's axes and turns with it, so that the pull is also a torque about the body's centre. In periodic space `d`
//! leads to that image of the second body whose centre is nearest to the first one's.
//!
//! A step takes the loads of explicit bonds where it takes every force, at its start or in its middle: it is stable
//! where `dt` is short for the stiffness (docs/motion.md). Implicit bonds are rows of the step's LCP instead
//! ([`crate::constraint`]): their pull is that at its end, and any stiffness is stable. A bond whose tension is over
//! its `break_force` at a step's end is broken from then on.
//!
//! A bond may also resist bends of its bodies ([`turning`]); such a bond is implicit. A joint is an implicit bond of
//! length 0 that may resist turns.

pub(crate) mod bending;
pub(crate) mod daughters;
mod incidence;
pub(crate) mod joint;
mod network;
#[cfg(feature = "files")]
pub(crate) mod stiffness;
pub(crate) mod turning;

pub use bending::Bending;
pub use daughters::DaughterBond;
pub use incidence::Incidence;
pub use joint::Joint;
pub(crate) use network::{Member, Unstable, instability};

use super::Load;
use crate::bodies::{Bodies, HeldBond, Lineage, sorted_pairs};
use crate::motion::Pose;
use crate::periodic::Periods;
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;
use std::num::NonZeroU32;
use turning::{Resists, Turn, Turning};

/// A spring between points of two bodies.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Bond {
    /// The indices of its two bodies, from 0: those of `bodies` in order, then those that `generate` places.
    pub bodies: [usize; 2],
    /// Its end point on each body, in body axes; it may be outside the body.
    pub at: [[f64; 3]; 2],
    /// Its stiffness, force over distance; or `"rigid"`, which is an infinite one in code.
    #[cfg_attr(feature = "files", serde(with = "stiffness"), schemars(with = "stiffness::Stiffness"))]
    pub stiffness: f64,
    /// Whether a step takes its pull at the step's end, where any stiffness is stable, and not at its start. Without
    /// it: rigid bonds do, and all do where explicit ones would be unstable in steps of `time.dt`. Only with
    /// `"euler"` steps.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub implicit: Option<bool>,
    /// Its rest length.
    #[cfg_attr(feature = "files", serde(default), schemars(range(min = 0.0)))]
    pub length: f64,
    /// Its bending stiffness: the torque over the angle, in radians, between the directions of both bodies, which are
    /// parallel at rest. A bond of some length bends at both ends, half of the angle at each. A bond with it is
    /// implicit. Without it: bodies turn freely.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", serde(with = "bending::json"), schemars(with = "bending::json::NumberOrBending"))]
    pub bending: Option<Bending>,
    /// The tension above which it breaks. Without it: never.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub break_force: Option<f64>,
    /// Whether its bodies collide with each other.
    #[cfg_attr(feature = "files", serde(default = "collides", skip_serializing_if = "is_true"))]
    pub contact: bool,
}

/// The default of `contact`.
#[cfg(feature = "files")]
pub(crate) const fn collides() -> bool {
    true
}

/// Whether a flag has its default.
#[cfg(feature = "files")]
pub(crate) const fn is_true(flag: &bool) -> bool {
    *flag
}

impl Bond {
    /// An unbreakable bond of length 0 between points of two bodies, body axes.
    pub const fn new(bodies: [usize; 2], at: [[f64; 3]; 2], stiffness: f64) -> Bond {
        Bond { bodies, at, stiffness, implicit: None, length: 0.0, bending: None, break_force: None, contact: true }
    }

    /// An unbreakable bond that keeps its length of 0: a ball joint.
    ///
    /// ```
    /// use relcp::scene::Bond;
    /// let joint = Bond::rigid([0, 1], [[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]]);
    /// assert!(joint.is_rigid() && !Bond::new([0, 1], [[0.0; 3]; 2], 5.0).is_rigid());
    /// ```
    pub const fn rigid(bodies: [usize; 2], at: [[f64; 3]; 2]) -> Bond {
        Bond::new(bodies, at, f64::INFINITY)
    }

    /// Whether it keeps its length.
    pub const fn is_rigid(&self) -> bool {
        self.stiffness.is_infinite()
    }

    /// Whether it is explicit where explicit bonds are stable.
    pub(crate) fn may_be_explicit(&self) -> bool {
        !self.is_rigid() && self.implicit != Some(true) && self.bending.is_none()
    }

    /// The directions that bends are between, unit vectors in body axes: those of its bending stiffness, or else those
    /// of its points. Not finite where these are at the centres.
    pub(crate) fn axes(&self) -> [DVec3; 2] {
        let of_points = || [DVec3::from(self.at[0]), -DVec3::from(self.at[1])];
        let given = self.bending.and_then(|bending| bending.axes);
        given.map_or_else(of_points, |axes| axes.map(DVec3::from)).map(DVec3::normalize)
    }

    /// What it resists beside its stretch.
    fn turning(&self) -> Option<Turning> {
        self.bending.map(|Bending { stiffness, .. }| Turning { stiffness, resists: Resists::Bend(self.axes()) })
    }

    /// The length by which an angle becomes one: of the longest arm, or of itself.
    fn reach(&self) -> f64 {
        self.at.map(|at| DVec3::from(at).length()).into_iter().fold(self.length, f64::max)
    }

    /// Its pull on the first of two points with `way` from it to the other. Where both are one point, a bond of some
    /// length has no direction: it does nothing.
    fn pull(&self, way: DVec3) -> DVec3 {
        if self.length == 0.0 {
            return self.stiffness * way;
        }
        let distance = way.length();
        if distance > 0.0 { self.stiffness * (1.0 - self.length / distance) * way } else { DVec3::ZERO }
    }

    /// Whether it breaks with `way` between its points.
    fn breaks(&self, way: DVec3) -> bool {
        self.break_force.is_some_and(|most| self.stiffness * (way.length() - self.length) > most)
    }
}

/// What messages call a bond: its place in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BondName(NonZeroU32);

/// Joints are named from here on: a scene has no more than 2^24 bonds.
const FIRST_JOINT: u32 = 1 << 30;

impl BondName {
    /// A bond of daughters.
    pub const DAUGHTERS: BondName = BondName(NonZeroU32::MAX);

    /// Bond number `bond` of the scene's `bonds`, or after those of the chains of `generate`.
    pub fn bond(bond: usize) -> BondName {
        BondName(NonZeroU32::MIN.saturating_add(bond as u32))
    }

    /// Joint number `joint` of the scene.
    pub fn joint(joint: usize) -> BondName {
        BondName(NonZeroU32::MIN.saturating_add(FIRST_JOINT + joint as u32))
    }
}

impl std::fmt::Display for BondName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let number = self.0.get() - 1;
        match number.checked_sub(FIRST_JOINT) {
            _ if *self == BondName::DAUGHTERS => write!(f, "a bond of daughters"),
            Some(joint) => write!(f, "joints[{joint}]"),
            None => write!(f, "bonds[{number}]"),
        }
    }
}

/// The bonds and joints of a scene. They refer to bodies by id, whatever their later indices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bonds {
    list: Vec<Bond>,
    ids: Vec<[u64; 2]>,
    /// What each bond resists beside its stretch.
    turning: Vec<Option<Turning>>,
    /// The joints, which come after the bonds, and how they rest.
    joints: Vec<(Joint, DQuat)>,
    /// Whether bonds that leave it open are implicit.
    open_ones_implicit: bool,
}

impl Bonds {
    /// These bonds, of bodies with these ids by number. Those that do not say whether they are implicit are explicit
    /// unless they are rigid.
    pub fn new(list: &[Bond], id: impl Fn(usize) -> u64) -> Bonds {
        let ids = list.iter().map(|bond| bond.bodies.map(&id)).collect();
        let turning = list.iter().map(Bond::turning).collect();
        Bonds { ids, list: list.to_vec(), turning, joints: Vec::new(), open_ones_implicit: false }
    }

    /// Adds joints with the orientation of each one's second body in the axes of its first, which are numbered after
    /// the bonds.
    pub fn with_joints(mut self, joints: Vec<(Joint, DQuat)>, planar: bool, id: impl Fn(usize) -> u64) -> Bonds {
        self.ids.extend(joints.iter().map(|(joint, _)| joint.bodies().map(&id)));
        self.turning.extend(joints.iter().map(|(joint, rest)| joint.turning(*rest, planar)));
        self.list.extend(joints.iter().map(|(joint, _)| joint.bond()));
        self.joints = joints;
        self
    }

    /// Makes those implicit that do not say whether they are.
    pub fn with_open_ones_implicit(self) -> Bonds {
        Bonds { open_ones_implicit: true, ..self }
    }

    /// Whether a bond is implicit.
    pub fn is_implicit(&self, bond: usize) -> bool {
        let of = &self.list[bond];
        of.implicit.unwrap_or(self.open_ones_implicit) || of.is_rigid() || self.turning[bond].is_some()
    }

    /// Whether it keeps its length or an angle.
    pub fn keeps_something(&self, bond: usize) -> bool {
        self.list[bond].is_rigid() || self.turning[bond].is_some_and(|turning| turning.stiffness.is_infinite())
    }

    /// Whether any has a bending stiffness and a length that load may take from it.
    pub fn bend_softly(&self) -> bool {
        self.list.iter().zip(&self.turning).any(|(bond, turn)| turn.is_some() && bond.length > 0.0 && !bond.is_rigid())
    }

    /// The first bond that is implicit.
    pub fn first_implicit(&self) -> Option<usize> {
        (0..self.list.len()).find(|bond| self.is_implicit(*bond))
    }

    /// The implicit bonds that hold, with their bodies; while bodies are parted only those that keep a length or an
    /// angle.
    pub fn implicit(&self, bodies: &Bodies, parting: bool) -> Vec<(usize, [usize; 2])> {
        if self.first_implicit().is_none() {
            return Vec::new();
        }
        let incidence = self.incidence(&bodies.lineage, &bodies.broken_bonds);
        let acts = |bond: &usize| if parting { self.keeps_something(*bond) } else { self.is_implicit(*bond) };
        let held = (0..self.list.len()).filter(acts);
        held.filter_map(|bond| Some((bond, incidence.pair(bond)?))).collect()
    }

    /// Whether any keeps its bodies from colliding.
    pub fn any_without_contact(&self) -> bool {
        self.list.iter().any(|bond| !bond.contact)
    }

    /// The pairs of these bodies that bonds keep from colliding, the lower row first, ascending.
    pub(crate) fn without_contact(&self, incidence: &Incidence) -> Vec<[u32; 2]> {
        let bonds = (0..self.list.len()).filter(|bond| !self.list[*bond].contact);
        sorted_pairs(bonds.filter_map(|bond| incidence.pair(bond)).map(|pair| pair.map(|body| body as u32)))
    }

    /// What a bond is called, and its bodies by their present rows.
    pub fn name(&self, bond: usize) -> BondName {
        match bond.checked_sub(self.list.len() - self.joints.len()) {
            Some(joint) => BondName::joint(joint),
            None => BondName::bond(bond),
        }
    }

    /// Whether any keeps a length or an angle.
    pub fn keep_something(&self) -> bool {
        (0..self.list.len()).any(|bond| self.keeps_something(bond))
    }

    /// By how much the worst rigid bond is off its length, or off its angle at its reach.
    pub fn rigid_stretch(&self, bodies: &Bodies) -> f64 {
        let of = |(bond, pair): (usize, [usize; 2])| {
            let (list, poses) = (&self.list[bond], pair.map(|body| bodies.pose(body)));
            let way = self.between_poses(bond, &bodies.periods, poses).1;
            let stretch = if list.is_rigid() { (way.length() - list.length).abs() } else { 0.0 };
            let turns = self.turns(bond, (poses, way), bodies.planar).into_iter();
            let rigid = turns.filter(|turn| turn.compliance == 0.0);
            rigid.map(|turn| self.reach(bond) * turn.angle.length()).fold(stretch, f64::max)
        };
        self.implicit(bodies, true).into_iter().map(of).fold(0.0, f64::max)
    }

    /// The turns of bodies in these poses that a bond resists, which is `way` from its first point to the second.
    pub(crate) fn turns(&self, bond: usize, (poses, way): ([Pose; 2], DVec3), planar: bool) -> Vec<Turn> {
        let turning = &self.turning[bond];
        turning.as_ref().map_or(Vec::new(), |turning| turning.turns(poses, way, self.list[bond].length, planar))
    }

    /// Whether a bond resists turns.
    pub fn resists_turns(&self, bond: usize) -> bool {
        self.turning[bond].is_some()
    }

    /// The length at which a bond's angles count.
    pub fn reach(&self, bond: usize) -> f64 {
        self.list[bond].reach()
    }

    /// Whether there is no bond.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// All bonds, broken ones too.
    pub fn list(&self) -> &[Bond] {
        &self.list
    }

    /// The ids of the bodies that each holds, and where in their axes.
    #[cfg(feature = "files")]
    pub(crate) fn ends(&self) -> Vec<([u64; 2], [[f64; 3]; 2])> {
        self.ids.iter().copied().zip(self.list.iter().map(|bond| bond.at)).collect()
    }

    /// Whether any of them can break.
    #[cfg(feature = "gpu")]
    pub fn may_break(&self) -> bool {
        self.list.iter().any(|bond| bond.break_force.is_some())
    }

    /// The ids of the bodies of the bonds that are not among the `broken` ones, which are sorted.
    #[cfg(feature = "mpi")]
    pub(crate) fn holding(&self, broken: &[u32]) -> Vec<[u64; 2]> {
        let holds = |bond: u32| broken.binary_search(&bond).is_err();
        (0..).zip(&self.ids).filter(|(bond, _)| holds(*bond)).map(|(_, ids)| *ids).collect()
    }

    /// Which bonds hold each of the bodies of these lines; `broken`, sorted, hold none.
    pub fn incidence(&self, lineage: &[Lineage], broken: &[u32]) -> Incidence {
        Incidence::new(&self.ids, lineage, broken)
    }

    /// The load of all bonds on body `i`, in the order of the scene's list.
    pub fn load(&self, incidence: &Incidence, bodies: &Bodies, i: usize) -> Load {
        let mut load = Load::default();
        for (bond, end, pair) in incidence.of(i).filter(|(bond, ..)| !self.is_implicit(*bond)) {
            let (arms, way) = self.between(bond, bodies, pair);
            let pull = self.list[bond].pull(way);
            let force = if end == 0 { pull } else { -pull };
            load += Load { force, torque: arms[end].cross(force) };
        }
        load
    }

    /// Adds to the broken bonds the explicit ones that break where `bodies` are now.
    pub fn find_broken(&self, incidence: &Incidence, bodies: &mut Bodies) {
        let breaks = |bond: &usize| {
            incidence.pair(*bond).is_some_and(|pair| self.list[*bond].breaks(self.between(*bond, bodies, pair).1))
        };
        let explicit = (0..self.list.len()).filter(|bond| !self.is_implicit(*bond));
        let found: Vec<u32> = explicit.filter(breaks).map(|bond| bond as u32).collect();
        bodies.add_broken_bonds(found);
    }

    /// From the centre of each body to its point, and from the first point to the other, space axes.
    fn between(&self, bond: usize, bodies: &Bodies, pair: [usize; 2]) -> ([DVec3; 2], DVec3) {
        self.between_poses(bond, &bodies.periods, pair.map(|body| bodies.pose(body)))
    }

    /// The same with its bodies in these poses.
    pub fn between_poses(&self, bond: usize, periods: &Periods, [a, b]: [Pose; 2]) -> ([DVec3; 2], DVec3) {
        let at = self.list[bond].at.map(DVec3::from);
        let arms = [a.orientation * at[0], b.orientation * at[1]];
        (arms, periods.nearest(b.position - a.position) + (arms[1] - arms[0]))
    }

    /// The bonds that hold, as a state has them. Explicit ones pull as they are there, and implicit ones as `pulls` has
    /// it, by number: the force on the second body at its end, and the torque about that.
    pub fn held(&self, bodies: &Bodies, pulls: &BTreeMap<usize, [DVec3; 2]>) -> Vec<HeldBond> {
        if self.list.is_empty() {
            return Vec::new();
        }
        let incidence = self.incidence(&bodies.lineage, &bodies.broken_bonds);
        let held = (0..self.list.len()).filter_map(|bond| Some((bond, incidence.pair(bond)?)));
        held.map(|(bond, pair)| self.as_held(bond, pair, bodies, pulls.get(&bond).copied())).collect()
    }

    /// A bond between these bodies, as a state has it.
    pub(crate) fn as_held(&self, bond: usize, pair: [usize; 2], bodies: &Bodies, pull: Option<[DVec3; 2]>) -> HeldBond {
        let (of, poses) = (&self.list[bond], pair.map(|body| bodies.pose(body)));
        let way = self.between_poses(bond, &bodies.periods, poses).1;
        let [force, torque] = match pull {
            _ if !self.is_implicit(bond) => [-of.pull(way), DVec3::ZERO],
            pull => pull.unwrap_or_default(),
        };
        let energy = |turn: Turn| {
            if turn.compliance > 0.0 { 0.5 * turn.angle.length_squared() / turn.compliance } else { 0.0 }
        };
        HeldBond {
            number: bond as u32,
            bodies: pair.map(|body| body as u32),
            at: of.at.map(DVec3::from),
            length: of.length,
            force,
            torque,
            bending_energy: self.turns(bond, (poses, way), bodies.planar).into_iter().map(energy).sum(),
            contact: of.contact,
        }
    }

    /// The unbroken bonds and joints, with the present indices of their bodies. Joints have how they rest.
    pub fn left(&self, bodies: &Bodies) -> (Vec<Bond>, Vec<Joint>) {
        let incidence = self.incidence(&bodies.lineage, &bodies.broken_bonds);
        let bonds = self.list.len() - self.joints.len();
        let left = |(number, bond): (usize, &Bond)| Some(Bond { bodies: incidence.pair(number)?, ..bond.clone() });
        let joint = |(number, (joint, rest)): (usize, &(Joint, DQuat))| {
            Some(joint.with(incidence.pair(bonds + number)?, Some([rest.w, rest.x, rest.y, rest.z])))
        };
        let joints = self.joints.iter().enumerate().filter_map(joint).collect();
        (self.list[..bonds].iter().enumerate().filter_map(left).collect(), joints)
    }
}
