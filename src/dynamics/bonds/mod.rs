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

mod incidence;
mod network;
#[cfg(feature = "files")]
pub(crate) mod stiffness;

pub use incidence::Incidence;
pub(crate) use network::{Member, Unstable, instability};

use super::Load;
use crate::bodies::{Bodies, Lineage};
use crate::motion::Pose;
use crate::periodic::Periods;
use glam::DVec3;

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
    /// it: rigid bonds do, and all do where explicit ones would be unstable in steps of `time.dt`. Only on the CPU,
    /// with `"euler"` steps.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub implicit: Option<bool>,
    /// Its rest length.
    #[cfg_attr(feature = "files", serde(default), schemars(range(min = 0.0)))]
    pub length: f64,
    /// The tension above which it breaks. Without it: never.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub break_force: Option<f64>,
}

impl Bond {
    /// An unbreakable bond of length 0 between points of two bodies, body axes.
    pub const fn new(bodies: [usize; 2], at: [[f64; 3]; 2], stiffness: f64) -> Bond {
        Bond { bodies, at, stiffness, implicit: None, length: 0.0, break_force: None }
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
        !self.is_rigid() && self.implicit != Some(true)
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

/// The bonds of a scene. They refer to bodies by id, whatever their later indices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bonds {
    list: Vec<Bond>,
    ids: Vec<[u64; 2]>,
    /// Whether bonds that leave it open are implicit.
    open_ones_implicit: bool,
}

impl Bonds {
    /// These bonds, of bodies with these ids by number. Those that do not say whether they are implicit are explicit
    /// unless they are rigid.
    pub fn new(list: &[Bond], id: impl Fn(usize) -> u64) -> Bonds {
        let ids = list.iter().map(|bond| bond.bodies.map(&id)).collect();
        Bonds { ids, list: list.to_vec(), open_ones_implicit: false }
    }

    /// Makes those implicit that do not say whether they are.
    pub fn with_open_ones_implicit(self) -> Bonds {
        Bonds { open_ones_implicit: true, ..self }
    }

    /// Whether a bond is implicit.
    pub fn is_implicit(&self, bond: usize) -> bool {
        let bond = &self.list[bond];
        bond.implicit.unwrap_or(self.open_ones_implicit) || bond.is_rigid()
    }

    /// The first bond that is implicit.
    pub fn first_implicit(&self) -> Option<usize> {
        (0..self.list.len()).find(|bond| self.is_implicit(*bond))
    }

    /// The implicit bonds that hold, with their bodies; while bodies are parted only the rigid ones.
    pub fn implicit(&self, bodies: &Bodies, parting: bool) -> Vec<(usize, [usize; 2])> {
        if self.first_implicit().is_none() {
            return Vec::new();
        }
        let incidence = self.incidence(&bodies.lineage, &bodies.broken_bonds);
        let acts = |bond: &usize| if parting { self.list[*bond].is_rigid() } else { self.is_implicit(*bond) };
        let held = (0..self.list.len()).filter(acts);
        held.filter_map(|bond| Some((bond, incidence.pair(bond)?))).collect()
    }

    /// By how much the worst rigid bond is off its length.
    pub fn rigid_stretch(&self, bodies: &Bodies) -> f64 {
        let of = |(bond, pair): (usize, [usize; 2])| {
            (self.between(bond, bodies, pair).1.length() - self.list[bond].length).abs()
        };
        self.implicit(bodies, true).into_iter().map(of).fold(0.0, f64::max)
    }

    /// Whether there is no bond.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// All bonds, broken ones too.
    pub fn list(&self) -> &[Bond] {
        &self.list
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
        let pose = |body: usize| Pose { position: bodies.position[body], orientation: bodies.orientation[body] };
        self.between_poses(bond, &bodies.periods, pair.map(pose))
    }

    /// The same with its bodies in these poses.
    pub fn between_poses(&self, bond: usize, periods: &Periods, [a, b]: [Pose; 2]) -> ([DVec3; 2], DVec3) {
        let at = self.list[bond].at.map(DVec3::from);
        let arms = [a.orientation * at[0], b.orientation * at[1]];
        (arms, periods.nearest(b.position - a.position) + (arms[1] - arms[0]))
    }

    /// The unbroken bonds, with the present indices of their bodies.
    pub fn left(&self, bodies: &Bodies) -> Vec<Bond> {
        let incidence = self.incidence(&bodies.lineage, &bodies.broken_bonds);
        let left = |(number, bond): (usize, &Bond)| Some(Bond { bodies: incidence.pair(number)?, ..bond.clone() });
        self.list.iter().enumerate().filter_map(left).collect()
    }
}
