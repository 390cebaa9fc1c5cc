//! The halo: bodies of other processes that this process's bodies may meet in a step.
//!
//! Each process sends all others the bounding box of its own bodies. It sends each of its bodies to the processes whose
//! box that body's box touches. So both owners of a pair of touching boxes have both bodies. Bonds reach farther: a
//! process requests the bodies that its bonds need.

use super::members::{MEMBER, Member, Members};
use crate::bodies::Bodies;
use crate::broad_phase::{BroadPhase, Grid, Periodic};
use crate::lcp::domain::{Route, route};
use crate::motion::Aabb;
use crate::periodic::Periods;
use crate::processes::Processes;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// The bodies of a domain and its halo.
pub(super) struct Halo {
    pub members: Members,
    /// The widened boxes.
    pub boxes: Vec<Aabb>,
    /// The pairs whose widened boxes touch, one of them an own body; ascending.
    pub pairs: Vec<[u32; 2]>,
    /// The own bodies that others need, and others' bodies, by process.
    pub out: Route,
    pub into: Route,
}

impl Halo {
    /// The halo of the `own` bodies. `bonds` are the ids of the bodies of the scene's unbroken bonds.
    pub fn new(processes: Processes, own: Members, periods: Periods, cutoff: f64, bonds: &[[u64; 2]]) -> Self {
        let rank = processes.rank() as u32;
        let like = own.bodies.none_like();
        let mut near = with_near(processes, own, periods, cutoff, &like);
        let boxes: Vec<Aabb> = (0..near.len()).map(|i| widened(&near, i, near.bodies.position[i], cutoff)).collect();
        let mut touching = Vec::new();
        Periodic::new(Grid::default(), periods).pairs(&boxes, &mut touching);
        touching.retain(|pair| pair.iter().any(|i| near.owner[*i as usize] == rank));
        let number = |pair: &[u32; 2], near: &Members| pair.map(|i| near.known[i as usize].number);
        let touching: Vec<[u32; 2]> = touching.iter().map(|pair| number(pair, &near)).collect();
        let touched: BTreeSet<u32> = touching.iter().flatten().copied().collect();
        let stays = |i: usize| near.owner[i] == rank || touched.contains(&near.known[i].number);
        near.retain(&(0..near.len()).map(stays).collect::<Vec<bool>>());
        // The pairs that need an exchange of velocities.
        let mut reasons = touching.clone();
        if !bonds.is_empty() {
            let bonded = Bonded::new(processes, &near, bonds);
            near = bonded.complete(processes, near, &like, |owner| owner == rank);
            reasons.extend(bonded.pairs(&near));
            // The loads on halo bodies are computed on this process too, so it needs their partners in bonds.
            near = bonded.complete(processes, near, &like, |_| true);
        }
        let (mut out, mut into) = (Vec::new(), Vec::new());
        for pair in &reasons {
            for [own, other] in [*pair, [pair[1], pair[0]]] {
                let (Some(own), Some(other)) = (near.find(own), near.find(other)) else { continue };
                if near.owner[own] == rank && near.owner[other] != rank {
                    let whose = near.owner[other] as usize;
                    out.push((whose, own as u32));
                    into.push((whose, other as u32));
                }
            }
        }
        let at = |number: u32| near.known.partition_point(|known| known.number < number) as u32;
        Halo {
            boxes: (0..near.len()).map(|i| widened(&near, i, near.bodies.position[i], cutoff)).collect(),
            pairs: touching.into_iter().map(|pair| pair.map(at)).collect(),
            members: near,
            out: route(out),
            into: route(into),
        }
    }
}

/// The box in which body `i` stays in the step, widened by half the cutoff.
fn widened(members: &Members, i: usize, centre: DVec3, cutoff: f64) -> Aabb {
    let wide = DVec3::splat(0.5 * cutoff + members.known[i].way);
    Aabb::from_centre(centre, members.bodies.shape[i].half_extents(members.bodies.orientation[i]) + wide)
}

/// The own bodies, and others whose boxes touch the bounding box of the own ones.
fn with_near(processes: Processes, own: Members, periods: Periods, cutoff: f64, like: &Bodies) -> Members {
    let none = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
    let of_own = (0..own.len()).map(|i| widened(&own, i, periods.wrapped(own.bodies.position[i]).0, cutoff));
    let hull = of_own.fold(none, |hull, aabb| Aabb { min: hull.min.min(aabb.min), max: hull.max.max(aabb.max) });
    let mut hulls = vec![0.0; 6 * processes.size()];
    processes.all_gather_even(&[hull.min.to_array(), hull.max.to_array()].concat(), &mut hulls);
    let corners = |[a, b, c, d, e, f]: &[f64; 6]| Aabb { min: DVec3::new(*a, *b, *c), max: DVec3::new(*d, *e, *f) };
    let others: Vec<(usize, Aabb)> = hulls.as_chunks::<6>().0.iter().map(corners).enumerate().collect();
    let of_others = |(process, hull): &&(usize, Aabb)| *process != processes.rank() && hull.is_proper();
    let mut lists = vec![Vec::new(); processes.size()];
    for i in 0..own.len() {
        let aabb = widened(&own, i, own.bodies.position[i], cutoff);
        for (process, hull) in others.iter().filter(of_others) {
            if periods.touches(hull, &aabb) {
                lists[*process].extend(own.words(i));
            }
        }
    }
    let come = processes.all_to_all(lists);
    Members::new(own.into_words().into_iter().chain(arrived(&come)).collect(), like)
}

/// What came from each process.
pub(super) fn arrived(come: &[Vec<u64>]) -> impl Iterator<Item = Member> + '_ {
    (0..)
        .zip(come)
        .flat_map(|(process, words)| words.as_chunks::<MEMBER>().0.iter().map(move |words| (process, *words)))
}

/// Bodies that bonds hold, by their ids.
struct Bonded {
    rank: u32,
    /// The ids of a body's partners in bonds.
    partners: BTreeMap<u64, Vec<u64>>,
    /// The owner of a bonded body.
    owner: BTreeMap<u64, u32>,
}

impl Bonded {
    /// The bonds of the bodies in the halos of all processes. Collective.
    fn new(processes: Processes, members: &Members, bonds: &[[u64; 2]]) -> Self {
        let mut partners: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
        for [a, b] in bonds {
            partners.entry(*a).or_default().push(*b);
            partners.entry(*b).or_default().push(*a);
        }
        let rank = processes.rank() as u32;
        let own = (0..members.len()).filter(|i| members.owner[*i] == rank).map(|i| members.bodies.lineage[i].id);
        let own: Vec<u64> = own.filter(|id| partners.contains_key(id)).flat_map(|id| [id, u64::from(rank)]).collect();
        let all = processes.all_gather(&own);
        let owner = all.as_chunks::<2>().0.iter().map(|[id, process]| (*id, *process as u32)).collect();
        Bonded { rank, partners, owner }
    }

    fn partners(&self, id: u64) -> impl Iterator<Item = u64> + '_ {
        self.partners.get(&id).into_iter().flatten().copied()
    }

    /// Requests from their owners the missing partners in bonds of the members that belong to processes `of`.
    fn complete(&self, processes: Processes, members: Members, like: &Bodies, of: impl Fn(u32) -> bool) -> Members {
        let line = &members.bodies.lineage;
        let here: BTreeMap<u64, usize> = line.iter().zip(0..).map(|(line, i)| (line.id, i)).collect();
        let asking = (0..members.len()).filter(|i| of(members.owner[*i]));
        let missing: BTreeSet<u64> =
            asking.flat_map(|i| self.partners(line[i].id)).filter(|id| !here.contains_key(id)).collect();
        let mut asked = vec![Vec::new(); processes.size()];
        for id in missing {
            if let Some(owner) = self.owner.get(&id) {
                asked[*owner as usize].push(id);
            }
        }
        let wanted = processes.all_to_all(asked);
        let answer = |ids: Vec<u64>| ids.iter().filter_map(|id| here.get(id)).flat_map(|i| members.words(*i)).collect();
        let come = processes.all_to_all(wanted.into_iter().map(answer).collect());
        let come: Vec<Member> = arrived(&come).collect();
        Members::new(members.into_words().into_iter().chain(come).collect(), like)
    }

    /// The bonded pairs with an own body, as global indices.
    fn pairs(&self, members: &Members) -> Vec<[u32; 2]> {
        let line = &members.bodies.lineage;
        let number: BTreeMap<u64, u32> =
            line.iter().zip(&members.known).map(|(line, known)| (line.id, known.number)).collect();
        let own = (0..members.len()).filter(|i| members.owner[*i] == self.rank);
        let pairs = own.flat_map(|i| self.partners(line[i].id).map(move |other| (i, other)));
        pairs.filter_map(|(i, other)| Some([members.known[i].number, *number.get(&other)?])).collect()
    }
}
