//! Which bodies of other processes those of this one may meet in a step.

use super::known::Known;
use crate::bodies::Bodies;
use crate::broad_phase::{BroadPhase, Grid, Periodic};
use crate::dynamics::Incidence;
use crate::lcp::domain::Route;
use crate::motion::Aabb;
use crate::periodic::Periods;
use glam::DVec3;
use std::collections::BTreeSet;

/// The bodies of a domain and its halo.
pub(super) struct Halo {
    /// Their numbers among all, ascending.
    pub members: Vec<u32>,
    /// Which of them are the process's own.
    pub own: Vec<bool>,
    /// The widened boxes.
    pub boxes: Vec<Aabb>,
    /// The pairs whose widened boxes touch, one of them an own body; ascending.
    pub pairs: Vec<[u32; 2]>,
    /// The own bodies that others need, and others' bodies, by process.
    pub out: Route,
    pub into: Route,
}

impl Halo {
    /// Of the process `rank`.
    pub fn new(
        rank: usize,
        all: &Bodies,
        periods: Periods,
        known: &Known,
        cutoff: f64,
        bonds: Option<&Incidence>,
    ) -> Self {
        let aabb = |body: usize, position: DVec3| {
            let wide = DVec3::splat(0.5 * cutoff + known.way[body]);
            Aabb::from_centre(position, all.shape[body].half_extents(all.orientation[body]) + wide)
        };
        let is_own = |body: usize| known.owner[body] as usize == rank;
        let none = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        let own = (0..all.len()).filter(|body| is_own(*body));
        let hull = own
            .map(|body| aabb(body, periods.wrapped(all.position[body]).0))
            .fold(none, |hull, aabb| Aabb { min: hull.min.min(aabb.min), max: hull.max.max(aabb.max) });
        let mut near: Vec<(u32, Aabb)> = Vec::new();
        for body in 0..all.len() {
            let aabb = aabb(body, all.position[body]);
            if is_own(body) || (hull.is_proper() && periods.touches(&hull, &aabb)) {
                near.push((body as u32, aabb));
            }
        }
        let boxes: Vec<Aabb> = near.iter().map(|(_, aabb)| *aabb).collect();
        let mut touching = Vec::new();
        Periodic::new(Grid::default(), periods).pairs(&boxes, &mut touching);
        let number = |pair: [u32; 2]| pair.map(|at| near[at as usize].0);
        touching.retain(|pair| number(*pair).iter().any(|body| is_own(*body as usize)));
        let all_bonded = || bonds.into_iter().flat_map(|bonds| bonds.pairs());
        let bonded = all_bonded().filter(|pair| pair.iter().any(|body| is_own(*body as usize)));
        // The pairs that are a reason to know each other.
        let reasons: Vec<[u32; 2]> = touching.iter().map(|pair| number(*pair)).chain(bonded).collect();
        let mut member: Vec<bool> = (0..all.len()).map(is_own).collect();
        reasons.iter().flatten().for_each(|body| member[*body as usize] = true);
        // The loads on bodies of the halo are computed here too: where their bonds lead to is known, no more.
        let known_too: Vec<u32> =
            all_bonded().filter(|pair| pair.iter().any(|body| member[*body as usize])).flatten().collect();
        known_too.into_iter().for_each(|body| member[body as usize] = true);
        let members: Vec<u32> = (0..all.len() as u32).filter(|body| member[*body as usize]).collect();
        let place = |body: u32| members.partition_point(|member| *member < body) as u32;
        let (mut out, mut into) = (BTreeSet::new(), BTreeSet::new());
        for pair in &reasons {
            for [own, other] in [*pair, [pair[1], pair[0]]] {
                let whose = known.owner[other as usize] as usize;
                if is_own(own as usize) && whose != rank {
                    out.insert((whose, place(own)));
                    into.insert((whose, place(other)));
                }
            }
        }
        Halo {
            own: members.iter().map(|body| is_own(*body as usize)).collect(),
            boxes: members.iter().map(|body| aabb(*body as usize, all.position[*body as usize])).collect(),
            pairs: touching.into_iter().map(|pair| number(pair).map(place)).collect(),
            members,
            out: route(out),
            into: route(into),
        }
    }

    /// The place of a body among the members.
    pub fn place(&self, body: usize) -> Option<usize> {
        self.members.binary_search(&(body as u32)).ok()
    }

    /// The members of all bodies.
    pub fn cut(&self, all: &Bodies) -> Bodies {
        fn of<T: Copy>(array: &[T], members: &[u32]) -> Vec<T> {
            members.iter().map(|body| array[*body as usize]).collect()
        }
        Bodies {
            shape: of(&all.shape, &self.members),
            position: of(&all.position, &self.members),
            orientation: of(&all.orientation, &self.members),
            velocity: of(&all.velocity, &self.members),
            angular_velocity: of(&all.angular_velocity, &self.members),
            group: of(&all.group, &self.members),
            lineage: of(&all.lineage, &self.members),
            broken_bonds: all.broken_bonds.clone(),
            periods: all.periods,
        }
    }
}

/// From pairs of a process and a place.
fn route(places: BTreeSet<(usize, u32)>) -> Route {
    let places: Vec<(usize, u32)> = places.into_iter().collect();
    places.chunk_by(|a, b| a.0 == b.0).map(|of| (of[0].0, of.iter().map(|(_, place)| *place).collect())).collect()
}
