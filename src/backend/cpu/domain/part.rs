//! A process's part of a state between two steps: its own bodies, and copies of their partners in pairs.

use super::members::{BODY, pack, push};
use crate::bodies::{Bodies, kept};
use crate::lcp::domain::{Route, route};
use crate::processes::Processes;
use crate::step::State;
use crate::walls::surface_of;
use crate::warm::Warm;
use glam::DVec3;
use std::collections::BTreeSet;

/// The cost of a body beside its rows, in rows: its poses, boxes and candidates. A step of a colony spends nine tenths
/// of its time on rows and near pairs, of which it has 2.7 a body.
pub(super) const WORK_OF_A_BODY: f64 = 1.0;

/// The initial estimate of a body's cost: the mean of a colony.
pub(super) const WORK_AT_FIRST: f64 = 3.5;

/// The initial and the smallest `way` of a body, as parts of the longest side of its box: bodies at rest may be hit.
/// They change no result, only how often a step is retried and the size of the halo.
const WAY_AT_FIRST: f64 = 0.05;
const LEAST_WAY: f64 = 0.02;

/// The bodies of a state that a process has. The state's arrays of bodies hold only these.
#[derive(Debug)]
pub(crate) struct Part {
    pub(super) rank: u32,
    /// How many bodies there are on all processes.
    pub all: usize,
    /// The global indices of this process's bodies, ascending, and their owners.
    pub members: Vec<u32>,
    pub owner: Vec<u32>,
    /// By process: the local indices of own bodies that it has copies of, and of copies of its bodies. Both sides list
    /// the same bodies in the same order.
    pub out: Route,
    pub into: Route,
    /// Of own bodies: the cost, and how far it may go in the next step.
    pub work: Vec<f64>,
    pub way: Vec<f64>,
}

impl Part {
    /// Reduces a state that all processes have to this process's part.
    pub fn of_whole(processes: Processes, state: &mut State) -> Part {
        let (rank, size) = (processes.rank(), processes.size());
        let (words, all) = (Part::pack([rank, size], state), state.bodies.len());
        Part::unpack([rank, size], all, &words, state)
    }

    /// Packs a process's first part of a state: an equal share of the bodies by global index, their partners in the
    /// warm start, and the warm start.
    pub fn pack([rank, size]: [usize; 2], state: &State) -> Vec<u64> {
        let edges = edges(state.bodies.len(), size);
        let is_own = |body: &u32| (edges[rank]..edges[rank + 1]).contains(&(*body as usize));
        let mut members: BTreeSet<u32> = (edges[rank] as u32..edges[rank + 1] as u32).collect();
        let own = |warm: &&Warm| bodies_of(warm).into_iter().flatten().any(|body| is_own(&body));
        let warm: Vec<&Warm> = state.warm.iter().filter(own).collect();
        members.extend(warm.iter().flat_map(|warm| bodies_of(warm)).flatten());
        let mut words = vec![members.len() as u64];
        members.iter().for_each(|body| {
            words.push(u64::from(*body));
            words.extend(pack(&state.bodies, *body as usize));
        });
        words.extend(warm.into_iter().flat_map(pack_warm));
        words
    }

    /// Unpacks into `state` a process's first part of a state of `all` bodies.
    pub fn unpack([rank, size]: [usize; 2], all: usize, words: &[u64], state: &mut State) -> Part {
        let (count, rest) = words.split_first().map_or((0, words), |(count, rest)| (*count as usize, rest));
        let (rows, rest) = rest.split_at(count * ROW);
        let members: Vec<u32> = rows.as_chunks::<ROW>().0.iter().map(|row| row[0] as u32).collect();
        state.bodies = bodies_in_order(rows, &state.bodies);
        state.warm = rest.as_chunks::<WARM>().0.iter().map(warm_of).collect();
        let edges = edges(all, size);
        let owner = |body: u32| edges.partition_point(|edge| *edge <= body as usize) - 1;
        let place = |body: u32| members.partition_point(|member| *member < body) as u32;
        let (mut out, mut into) = (Vec::new(), Vec::new());
        for bodies in state.warm.iter().map(bodies_of) {
            for [near, far] in [bodies, [bodies[1], bodies[0]]] {
                let (Some(near), Some(far)) = (near, far) else { continue };
                if owner(near) == rank && owner(far) != rank {
                    out.push((owner(far), place(near)));
                    into.push((owner(far), place(far)));
                }
            }
        }
        Part {
            rank: rank as u32,
            all,
            owner: members.iter().map(|body| owner(*body) as u32).collect(),
            out: route(out),
            into: route(into),
            work: vec![WORK_AT_FIRST; members.len()],
            way: (0..members.len()).map(|i| first_way(&state.bodies, i)).collect(),
            members,
        }
    }

    pub fn is_own(&self, i: usize) -> bool {
        self.owner[i] == self.rank
    }

    /// The own bodies.
    pub fn own(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.members.len()).filter(|i| self.is_own(*i))
    }

    /// The local index of a body.
    pub fn place(&self, body: u32) -> Option<usize> {
        self.members.binary_search(&body).ok()
    }

    /// The warm start, with local indices of bodies.
    pub fn by_place(&self, warm: &[Warm]) -> Vec<Warm> {
        let local = |warm: &Warm| {
            let [a, b] = warm.pair;
            let b = if surface_of(b).is_some() { b } else { self.place(b)? as u32 };
            Some(Warm { pair: [self.place(a)? as u32, b], ..*warm })
        };
        warm.iter().filter_map(local).collect()
    }

    /// The global indices and packed words of the own bodies.
    fn words(&self, bodies: &Bodies) -> Vec<u64> {
        self.own().flat_map(|i| std::iter::once(u64::from(self.members[i])).chain(pack(bodies, i))).collect()
    }

    /// All bodies of all processes. Collective.
    pub fn gather(&self, processes: Processes, bodies: &Bodies) -> Bodies {
        bodies_in_order(&processes.all_gather(&self.words(bodies)), bodies)
    }

    /// [`Part::gather`] on rank 0; the others get no bodies.
    pub fn gather_to_root(&self, processes: Processes, bodies: &Bodies) -> Bodies {
        let words = processes.gather_to_root(&self.words(bodies));
        if self.rank > 0 { Bodies::default() } else { bodies_in_order(&words, bodies) }
    }

    /// Removes the bodies with these sorted global indices.
    pub fn remove(&mut self, gone: &[u32], state: &mut State) {
        let stays = |body: u32| gone.binary_search(&body).is_err();
        let renumbered = |body: u32| body - gone.partition_point(|other| *other < body) as u32;
        let keep: Vec<bool> = self.members.iter().map(|body| stays(*body)).collect();
        let mut next = 0;
        let place = |kept: &bool| {
            let place = next;
            next += u32::from(*kept);
            kept.then_some(place)
        };
        let places: Vec<Option<u32>> = keep.iter().map(place).collect();
        for (_, route) in self.out.iter_mut().chain(&mut self.into) {
            *route = route.iter().filter_map(|i| places[*i as usize]).collect();
        }
        state.bodies.retain(&keep);
        kept(&mut self.members, &keep);
        kept(&mut self.owner, &keep);
        kept(&mut self.work, &keep);
        kept(&mut self.way, &keep);
        self.members.iter_mut().for_each(|body| *body = renumbered(*body));
        self.all -= gone.len();
        state.warm.retain_mut(|warm| {
            let [a, b] = warm.pair;
            let of_wall = surface_of(b).is_some();
            warm.pair = [renumbered(a), if of_wall { b } else { renumbered(b) }];
            stays(a) && (of_wall || stays(b))
        });
    }
}

/// Words of a global index and its body.
const ROW: usize = 1 + BODY;

/// The bodies of these rows, by global index; `like` has the data that belongs to no body.
fn bodies_in_order(rows: &[u64], like: &Bodies) -> Bodies {
    let mut rows: Vec<&[u64; ROW]> = rows.as_chunks().0.iter().collect();
    rows.sort_unstable_by_key(|row| row[0]);
    let mut bodies = like.none_like();
    for [_, body @ ..] in rows {
        push(&mut bodies, body);
    }
    bodies
}

/// The first global index of each process's first part, and the end.
fn edges(all: usize, size: usize) -> Vec<usize> {
    (0..=size).map(|process| all * process / size).collect()
}

/// The one or two bodies of a pair.
fn bodies_of(warm: &Warm) -> [Option<u32>; 2] {
    warm.pair.map(|body| surface_of(body).is_none().then_some(body))
}

fn longest_side(bodies: &Bodies, body: usize) -> f64 {
    2.0 * bodies.shape[body].half_extents(bodies.orientation[body]).max_element()
}

/// The initial estimate of how far a body may go.
pub(super) fn first_way(bodies: &Bodies, body: usize) -> f64 {
    WAY_AT_FIRST * longest_side(bodies, body)
}

/// The smallest estimate of how far a body may go.
pub(super) fn least_way(bodies: &Bodies, body: usize) -> f64 {
    LEAST_WAY * longest_side(bodies, body)
}

/// Words of a contact's warm start.
pub(super) const WARM: usize = 6;

pub(super) fn pack_warm(warm: &Warm) -> [u64; WARM] {
    // Steps with friction are not distributed.
    let Warm { pair: [a, b], feature, gamma, normal, .. } = *warm;
    let [x, y, z] = normal.to_array().map(f64::to_bits);
    [u64::from(a) << 32 | u64::from(b), feature.into(), gamma.to_bits(), x, y, z]
}

pub(super) fn warm_of(words: &[u64; WARM]) -> Warm {
    let [pair, feature, gamma, normal @ ..] = *words;
    Warm {
        pair: [(pair >> 32) as u32, pair as u32],
        feature: feature as u32,
        gamma: f64::from_bits(gamma),
        normal: DVec3::from_array(normal.map(f64::from_bits)),
        tangent: DVec3::ZERO,
    }
}

/// Sorted as in a state.
pub(super) fn sorted_warm(words: &[u64]) -> Vec<Warm> {
    let mut warm: Vec<Warm> = words.as_chunks::<WARM>().0.iter().map(warm_of).collect();
    warm.sort_unstable_by_key(|warm| (warm.pair, warm.feature));
    warm
}
