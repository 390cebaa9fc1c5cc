//! The rules of bonds.

use super::super::error::{FaultKind, SceneError};
use super::super::generate::bonds_of_chain;
use super::super::key::Key;
use super::super::{Bending, Bond, Generate, SMALLEST_NUMBER, Scene, generate};
use super::{MAX_BODIES, number, numbers, positive};
use crate::bodies::NO_GROUP;
use crate::digits::{at_most, exact, short};
use crate::dynamics::{Member, Unstable, instability};
use crate::fixed::Fixed;
use crate::shape::{PLANAR_TOLERANCE, Shape};
use glam::{DQuat, DVec3};

/// A starting body as its bonds know it.
pub(super) struct Bonded<'a> {
    shape: Shape,
    /// Its rotation, where the scene has it; in a planar scene up to a turn about z.
    pub(super) rotation: Option<DQuat>,
    group: Option<&'a str>,
}

/// All starting bodies as their bonds know them, those of one shape of a rule together.
pub(super) struct Roster<'a> {
    /// The number of bodies up to each entry.
    ends: Vec<u64>,
    bodies: Vec<Bonded<'a>>,
    count: u64,
}

impl<'a> Roster<'a> {
    fn push(&mut self, count: u64, body: Bonded<'a>) {
        self.ends.push(self.ends.last().copied().unwrap_or(0).saturating_add(count));
        self.bodies.push(body);
    }

    /// Body number `body`, where the scene has as many.
    pub(super) fn body(&self, body: usize) -> Option<&Bonded<'a>> {
        self.bodies.get(self.ends.partition_point(|end| *end <= body as u64))
    }

    /// Refuses a point or a direction of a body that is not in the plane.
    pub(super) fn check_in_plane(&self, key: &Key, body: usize, at: DVec3) -> Result<(), SceneError> {
        let out = |q: DQuat| (q * at).z.abs() > PLANAR_TOLERANCE * at.length();
        let known = self.body(body).and_then(|body| body.rotation);
        if at == DVec3::ZERO || !known.is_none_or(out) {
            return Ok(());
        }
        let message = format!(
            "is not in the plane on body {body}, as that is oriented; a rod's own axis, its z, is in the plane"
        );
        Err(SceneError::bad(key, message))
    }
}

/// The fixed bodies among those that bonds hold.
pub(super) struct Anchors {
    ids: Vec<u64>,
    names: Vec<String>,
    fixed: Fixed,
}

impl Anchors {
    /// Whether a body of this group is one.
    pub(super) fn hold(&self, body: usize, group: Option<&str>) -> bool {
        let group = self.names.iter().position(|name| Some(name.as_str()) == group);
        let group = group.map_or(NO_GROUP, |number| number as u32);
        self.fixed.holds(self.ids.get(body).copied().unwrap_or(u64::MAX), group)
    }
}

/// A bond, by how much of its stretch it takes back in a step.
pub(in crate::scene) struct StiffestBond {
    pub(in crate::scene) key: String,
    /// The part of its stretch.
    pub(in crate::scene) part: f64,
    pub(in crate::scene) is_implicit: bool,
}

/// One more than the largest number of a body that a bond holds.
fn held(bonds: &[Bond]) -> usize {
    bonds.iter().flat_map(|bond| bond.bodies).max().map_or(0, |last| last.saturating_add(1))
}

impl Scene {
    pub(super) fn check_bonds(&self, root: &Key) -> Result<(), SceneError> {
        let key = &root.field("bonds");
        if self.bonds.len() as u64 > MAX_BODIES {
            let message = format!("{} bonds; at most {MAX_BODIES}", self.bonds.len());
            return Err(SceneError::new(FaultKind::TooLarge, key, message));
        }
        let (all, roster) = (self.all_bonds(), self.roster());
        let anchors = self.anchors(held(&all));
        let is_fixed = |body: usize, group: Option<&str>| anchors.hold(body, group);
        for (i, bond) in self.bonds.iter().enumerate() {
            let key = key.index(i);
            check_numbers(&key, bond)?;
            check_bending(&key, bond)?;
            self.check_ends(&key, bond.bodies, &roster, &is_fixed)?;
            self.check_bond_length(&key.field("length"), bond.length)?;
        }
        self.check_chains(&is_fixed)?;
        if let Some(bond) = all.iter().position(|bond| !bond.may_be_explicit()) {
            self.check_supports(root, &format!("implicit bonds ({})", self.bond_key(key, bond)))?;
        }
        self.check_network(key)
    }

    /// The bonds of chains hold bodies that move and do not grow.
    fn check_chains(&self, is_fixed: &dyn Fn(usize, Option<&str>) -> bool) -> Result<(), SceneError> {
        let list = Key::ROOT.field("generate");
        for (i, rule) in self.generate.iter().enumerate() {
            let Generate::Chain(chain) = rule else { continue };
            let key = list.index(i);
            let key = key.field(rule.name());
            let group = chain.group.as_deref();
            if self.growth_of_body(group, &chain.shape).is_some() {
                let message = "the bodies grow, and a bond does not follow a division; name the species that grows \
                               with growth.group";
                return Err(SceneError::bad(key, message));
            }
            if is_fixed(usize::MAX, group) {
                return Err(SceneError::bad(key.field("group"), "is fixed, so the bonds do nothing; use `bodies`"));
            }
            let length = bonds_of_chain(chain, 0).first().map_or(0.0, |bond| bond.length);
            self.check_bond_length(&key.field("gap"), length)?;
        }
        Ok(())
    }

    /// The key of a bond: of one of `bonds`, or of its chain.
    fn bond_key(&self, key: &Key, bond: usize) -> String {
        let Some(mut after) = bond.checked_sub(self.bonds.len()) else { return key.index(bond).to_string() };
        for (i, rule) in self.generate.iter().enumerate() {
            let Generate::Chain(chain) = rule else { continue };
            let own = bonds_of_chain(chain, 0).len();
            if after < own {
                return format!("generate.{i}.chain");
            }
            after -= own;
        }
        key.to_string()
    }

    /// Refuses explicit bonds that a step makes grow, alone or together as those of a chain: those that are to be
    /// explicit, and all where the scene does not support implicit ones.
    fn check_network(&self, key: &Key) -> Result<(), SceneError> {
        let refusal = self.refuses_cones();
        let stays = |bond: &Bond| bond.may_be_explicit() && (bond.implicit.is_some() || refusal.is_some());
        let Some(Unstable { bond, longest }) = self.unstable_bonds(stays) else { return Ok(()) };
        let instead = match &refusal {
            Some(([outer, inner], why)) => format!("; implicit bonds conflict with {outer}.{inner}: {why}"),
            None => ", or leave out `implicit`".into(),
        };
        let message = format!(
            "is too stiff for time.dt, {dt}: all bonds together are unstable over {longest}, and this one grows most; \
             shorten time.dt, or lower the stiffness{instead}",
            dt = exact(self.time.dt),
            longest = at_most(longest)
        );
        Err(SceneError::bad(format!("{}.stiffness", self.bond_key(key, bond)), message))
    }

    /// Whether explicit steps make some of the bonds grow.
    fn unstable_bonds(&self, of: impl Fn(&Bond) -> bool) -> Option<Unstable> {
        let (numbers, bonds): (Vec<usize>, Vec<Bond>) =
            self.all_bonds().into_iter().enumerate().filter(|(_, bond)| of(bond)).unzip();
        let (roster, held) = (self.roster(), held(&bonds));
        let anchors = self.anchors(held);
        let member = |number: usize| {
            let Bonded { shape, rotation, group } = *roster.body(number)?;
            Some(Member { shape, orientation: rotation, fixed: anchors.hold(number, group) })
        };
        let members = (0..held).map(member).collect::<Option<Vec<_>>>()?;
        let unstable = instability(&bonds, &members, &self.dynamics, self.planar, self.time.dt)?;
        Some(Unstable { bond: numbers[unstable.bond], ..unstable })
    }

    /// Whether bonds that do not say so are implicit: where they would be unstable as explicit ones.
    pub(in crate::scene) fn makes_bonds_implicit(&self) -> bool {
        let open = |bond: &Bond| bond.may_be_explicit() && bond.implicit.is_none();
        self.all_bonds().iter().any(open)
            && self.refuses_cones().is_none()
            && self.unstable_bonds(Bond::may_be_explicit).is_some()
    }

    /// The bond that takes back the largest part `dt k (m_a + m_b)` of its stretch in a step of the overdamped law, `m`
    /// being the mobilities of its bodies; with this part, and whether it is implicit. Not of bonds that are rigid.
    pub(in crate::scene) fn stiffest_bond(&self) -> Option<StiffestBond> {
        let (all, bonds, roster) = (self.all_bonds(), self.bonds(), self.roster());
        let anchors = self.anchors(held(&all));
        let yields = |body: usize| {
            let Bonded { shape, group, .. } = roster.body(body)?;
            let fixed = anchors.hold(body, *group);
            Some(if fixed { 0.0 } else { self.dynamics.yields(shape, self.time.dt).0 })
        };
        let open = all.iter().enumerate().filter(|(_, bond)| !bond.is_rigid());
        let parts = open
            .filter_map(|(i, bond)| Some((i, bond.stiffness * (yields(bond.bodies[0])? + yields(bond.bodies[1])?))));
        let (bond, part) = parts.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let key = self.bond_key(&Key::ROOT.field("bonds"), bond);
        Some(StiffestBond { key, part, is_implicit: bonds.is_implicit(bond) })
    }

    /// Which of the first so many bodies are fixed.
    pub(super) fn anchors(&self, held: usize) -> Anchors {
        let known = usize::try_from(self.body_count()).unwrap_or(usize::MAX);
        Anchors { ids: self.ids().take(held.min(known)).collect(), names: self.group_names(), fixed: self.fixed() }
    }

    /// In a planar scene the points and the directions of a bond lie in the plane on each body as it is oriented.
    pub(super) fn check_planar_bonds(&self, key: &Key) -> Result<(), SceneError> {
        let roster = self.roster();
        for (i, bond) in self.bonds.iter().enumerate() {
            let key = key.index(i);
            for (end, (body, at)) in bond.bodies.into_iter().zip(bond.at).enumerate() {
                roster.check_in_plane(&key.field("at").index(end), body, at.into())?;
            }
            let axes = bond.bending.and_then(|bending| bending.axes).into_iter().flatten();
            for (end, (body, axis)) in bond.bodies.into_iter().zip(axes).enumerate() {
                let bending = key.field("bending");
                roster.check_in_plane(&bending.field("axes").index(end), body, axis.into())?;
            }
        }
        Ok(())
    }

    /// All starting bodies as bonds know them; none in a scene without bonds and joints.
    pub(super) fn roster(&self) -> Roster<'_> {
        let mut roster = Roster { ends: Vec::new(), bodies: Vec::new(), count: self.body_count() };
        if self.bonds.is_empty()
            && self.joints.is_empty()
            && !self.generate.iter().any(|rule| matches!(rule, Generate::Chain(_)))
        {
            return roster;
        }
        for of in &self.bodies {
            let (rotation, group) = (Some(of.rotation()), of.group.as_deref());
            roster.push(1, Bonded { shape: of.shape, rotation, group });
        }
        for rule in &self.generate {
            for (count, shape, group) in rule.components() {
                let rotation = generate::planar_orientation(rule, &shape).filter(|_| self.planar);
                roster.push(count, Bonded { shape, rotation, group });
            }
        }
        roster
    }

    pub(super) fn check_ends(
        &self,
        key: &Key,
        bodies: [usize; 2],
        roster: &Roster,
        is_fixed: &dyn Fn(usize, Option<&str>) -> bool,
    ) -> Result<(), SceneError> {
        let list = key.field("bodies");
        let mut holds = [false; 2];
        for (end, body) in bodies.into_iter().enumerate() {
            let Some(&Bonded { shape, group, .. }) = roster.body(body) else {
                let count = roster.count;
                let message = format!("there is no body {body}; the scene has {count} bodies, counted from 0");
                return Err(SceneError::bad(list.index(end), message));
            };
            if self.growth_of_body(group, &shape).is_some() {
                let message =
                    format!("body {body} grows, and a bond does not follow a division; bond bodies that do not grow");
                return Err(SceneError::bad(list.index(end), message));
            }
            holds[end] = is_fixed(body, group);
        }
        if bodies[0] == bodies[1] {
            return Err(SceneError::bad(list, "must be two different bodies"));
        }
        if holds == [true, true] {
            return Err(SceneError::bad(list, "are both fixed, so nothing can move them; omit it"));
        }
        Ok(())
    }

    pub(super) fn check_bond_length(&self, key: &Key, length: f64) -> Result<(), SceneError> {
        let Some(period) = self.periods().shortest() else { return Ok(()) };
        if length >= 0.5 * period {
            let message = format!(
                "must be under half of the shortest period, {period}: a bond ends at the nearest image of its body",
                period = short(period)
            );
            return Err(SceneError::bad(key, message));
        }
        Ok(())
    }
}

/// A bending stiffness needs a direction on each body.
fn check_bending(key: &Key, bond: &Bond) -> Result<(), SceneError> {
    let Some(Bending { stiffness, axes }) = bond.bending else { return Ok(()) };
    let key = key.field("bending");
    if bond.implicit == Some(false) {
        return Err(SceneError::bad(key, "conflicts with `implicit`, false: only an implicit bond has it"));
    }
    if !stiffness.is_infinite() {
        let key = if axes.is_some() { key.field("stiffness") } else { key };
        positive(&key, stiffness)?;
    }
    let Some(axes) = axes else {
        let Some(end) = bond.at.iter().position(|at| *at == [0.0; 3]) else { return Ok(()) };
        let message = format!(
            "body {body} has no direction, since the bond is at its centre; write {{\"stiffness\": ..., \"axes\": \
             [[x, y, z], [x, y, z]]}} with a direction on each body, or put `at` away from the centre",
            body = bond.bodies[end]
        );
        return Err(SceneError::bad(key, message));
    };
    if bond.at == [[0.0; 3]; 2] && bond.length == 0.0 {
        return Err(SceneError::bad(key, "needs an arm: `at` is at the centre of both bodies, and the length is 0"));
    }
    for (end, axis) in axes.iter().enumerate() {
        let list = key.field("axes");
        let key = list.index(end);
        numbers(&key, axis)?;
        if DVec3::from(*axis).length() < SMALLEST_NUMBER {
            return Err(SceneError::bad(key, "is no direction"));
        }
    }
    Ok(())
}

fn check_numbers(key: &Key, bond: &Bond) -> Result<(), SceneError> {
    for (end, at) in bond.at.iter().enumerate() {
        let list = key.field("at");
        numbers(&list.index(end), at)?;
    }
    if !bond.is_rigid() {
        positive(&key.field("stiffness"), bond.stiffness)?;
    } else if bond.implicit == Some(false) {
        let message = "conflicts with a rigid bond: only an implicit one is rigid";
        return Err(SceneError::bad(key.field("implicit"), message));
    }
    number(&key.field("length"), bond.length)?;
    if bond.length < 0.0 {
        return Err(SceneError::bad(key.field("length"), format!("must not be negative, not {}", exact(bond.length))));
    }
    bond.break_force.map_or(Ok(()), |force| positive(&key.field("break_force"), force))
}
