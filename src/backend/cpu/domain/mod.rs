//! The domain of one of several processes in a step: some blocks of near bodies ([`crate::bisection`]), and a halo, the
//! bodies of other processes that its own bodies may meet in the step.
//!
//! Between two steps a process has its own bodies and copies of their partners in pairs (`part`). It grows its own
//! bodies; all processes number the daughters together (`births`). Then all bodies are cut into blocks (`order`) and
//! sent to the processes that own these blocks in the step (`sharing`) and to those whose bodies they may meet
//! (`halo`). Each process takes the step with its domain and halo as one process takes a step of all bodies. A pair
//! across a border is a pair of both processes. They exchange the velocities of halo bodies and global sums and
//! maxima (`lcp::domain`; faults, overlaps). The state is gathered when it is requested.
//!
//! The halo is sufficient: each body's box with half the cutoff is widened by `way`, somewhat more than the body went
//! in the last step. Two bodies whose widened boxes do not touch cannot meet while both stay in them. The owner of a
//! body checks that it does. If a body leaves its box, all processes retry the step with wider boxes.

mod births;
mod halo;
mod members;
mod order;
mod part;
mod sharing;
mod team;
mod troubles;
mod whole;

pub(crate) use part::Part;
pub(crate) use team::{LocalState, shares};

use super::setup::Setup;
use super::start::Start;
use crate::bisection::MOST_IN_A_BLOCK;
use crate::bodies::{Bodies, Lineage, kept};
use crate::dynamics::Twist;
use crate::lcp::Places;
use crate::lcp::domain;
use crate::motion::Aabb;
use crate::processes::Processes;
use crate::step::{Divided, State};
use crate::warm::Warm;
use births::Births;
use halo::Halo;
use members::Members;
use sharing::Sharing;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Fewest bodies for each process: two blocks. An iteration on the rows of so many cells takes some 8 microseconds, and
/// its five exchanges take as much if a message takes one to two. With more processes, the last ones have no bodies and
/// only take part in the sums.
const LEAST_BODIES: usize = 2 * MOST_IN_A_BLOCK;

/// How much farther than in the last step a body may go before the step is retried. It changes no result.
const MARGIN: f64 = 1.5;

/// One of several processes that take steps together: a [`Team`](super::team::Team).
pub struct Domain {
    processes: Processes,
    /// Whether steps may be distributed; otherwise each process computes all of them.
    shares: bool,
    /// This process's part of the last accepted state; none if every process has all of it.
    part: Option<Part>,
    step: Option<Step>,
    /// Whether each process computes all of the present step.
    alone: bool,
    /// Whether to retry the present attempt, and how far bodies may go then, by global index.
    retry: bool,
    ways: BTreeMap<u32, f64>,
    /// The own bodies that the present attempt begins with, and the own mothers that divide in it.
    births: Births,
    dividing: Vec<Divided>,
    /// The mothers that divided in the last step, if it was distributed.
    divided: Option<Vec<Divided>>,
    /// The whole state, once gathered on rank 0, and all bodies, once gathered on all processes.
    whole_state: OnceLock<State>,
    all_bodies: OnceLock<Bodies>,
    /// The lineages of all bodies before the last step, if it began distributed and ended whole.
    lines_before: Option<Vec<Lineage>>,
}

/// A distributed step.
struct Step {
    part: Part,
    boxes: Vec<Aabb>,
    pairs: Vec<[u32; 2]>,
    /// The former owners of the own bodies, in their order.
    from: Vec<u32>,
    /// How far own bodies went beyond their boxes at rest.
    went: Vec<f64>,
}

/// A process's part of a distributed step.
struct Assigned {
    places: Places,
    domain: domain::Domain,
    warm: Vec<Warm>,
}

/// How many processes share so many bodies; none if one process is faster.
pub(crate) fn among(processes: Processes, bodies: usize) -> Option<usize> {
    Some(processes.size().min(bodies / LEAST_BODIES)).filter(|sharing| *sharing >= 2)
}

impl Domain {
    fn new(processes: Processes, shares: bool, part: Option<Part>) -> Self {
        Domain {
            processes,
            shares,
            part,
            step: None,
            alone: false,
            retry: false,
            ways: BTreeMap::new(),
            births: Births::default(),
            dividing: Vec::new(),
            divided: None,
            whole_state: OnceLock::new(),
            all_bodies: OnceLock::new(),
            lines_before: None,
        }
    }

    /// The global index of a body of the domain.
    fn number(&self, body: usize) -> usize {
        self.step.as_ref().map_or(body, |step| step.part.members[body] as usize)
    }

    /// How many processes share the next step; none if one process is faster.
    fn sharing(&self, state: &State) -> Option<usize> {
        let bodies = self.part.as_ref().map_or(state.bodies.len(), |part| part.all);
        among(self.processes, bodies).filter(|_| self.shares && !self.alone)
    }

    /// Begins a step. Returns whether it is distributed: then each process has a part of the state, else all of it.
    fn take_up(&mut self, state: &mut State) -> bool {
        (self.step, self.retry) = (None, false);
        self.drop_gathered();
        if self.sharing(state).is_none() {
            self.make_whole(state);
            return false;
        }
        self.part.get_or_insert_with(|| Part::of_whole(self.processes, state));
        true
    }

    /// The warm start, with indices of bodies in the part.
    fn by_place(&self, warm: &[Warm]) -> Vec<Warm> {
        self.part.as_ref().map_or_else(Vec::new, |part| part.by_place(warm))
    }

    /// Keeps in `start` the bodies that this process owns and grows.
    fn leave_own(&self, start: &mut Start) {
        let Some(part) = &self.part else { return };
        let own: Vec<bool> = (0..part.members.len()).map(|i| part.is_own(i)).collect();
        start.bodies.retain(&own);
        kept(&mut start.slowing, &own);
    }

    /// Distributes the step that begins with the own bodies of all processes in `start`. `start` keeps the bodies of
    /// this process's domain and halo.
    fn share(&mut self, setup: &Setup, start: &mut Start, state: &State) -> Option<Assigned> {
        let sharing = self.sharing(state)?;
        let (processes, part) = (self.processes, self.part.as_ref()?);
        let bodies = std::mem::take(&mut start.bodies);
        let Births { numbers, all } = std::mem::take(&mut self.births);
        let known = |of: &[f64], first: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let old: Vec<f64> = part.own().map(|i| of[i]).collect();
            (0..bodies.len()).map(|i| old.get(i).copied().unwrap_or_else(|| first(i))).collect()
        };
        let work = known(&part.work, &|_| part::WORK_AT_FIRST);
        let mut way = known(&part.way, &|i| part::first_way(&bodies, i));
        for (i, way) in way.iter_mut().enumerate() {
            let wider = self.ways.get(&numbers[i]).copied().unwrap_or(0.0);
            *way = way.max(part::least_way(&bodies, i)).max(wider);
        }
        let local = (numbers.as_slice(), &bodies);
        let shared = Sharing::new(processes, local, start.periods, &work, (sharing, all));
        let warm = shared.hand_over(processes, part, &state.warm);
        let (own, from) = shared.send(processes, local, &way, &start.slowing);
        let own = Members::new(own, &bodies);
        let bonded = !setup.bonds.is_empty() && !start.parting;
        let bonds = if bonded { setup.bonds.holding(&bodies.broken_bonds) } else { Vec::new() };
        let halo = Halo::new(processes, own, start.periods, setup.cutoff, &bonds);
        Some(self.take(halo, from, (shared, warm, setup.walls.len()), start))
    }

    /// Installs a domain with its halo.
    fn take(
        &mut self,
        halo: Halo,
        from: Vec<u32>,
        (shared, warm, walls): (Sharing, Vec<Warm>, usize),
        start: &mut Start,
    ) -> Assigned {
        let Halo { members, boxes, pairs, out, into } = halo;
        let rank = self.processes.rank() as u32;
        let all = shared.all;
        let (places, domain) = self.places(&members, shared, walls);
        let known = members.known;
        let part = Part {
            rank,
            all,
            members: known.iter().map(|known| known.number).collect(),
            owner: members.owner,
            out,
            into,
            work: vec![0.0; known.len()],
            way: known.iter().map(|known| known.way).collect(),
        };
        start.foreign = part.owner.iter().map(|owner| *owner != rank).collect();
        start.bodies = members.bodies;
        start.slowing = known.iter().map(|known| known.slowing).collect();
        log::debug!(
            "rank {rank}: {} bodies of {} and {} in the halo, {} pairs",
            from.len(),
            part.all,
            known.len() - from.len(),
            pairs.len()
        );
        let warm = part.by_place(&warm);
        self.step = Some(Step { went: vec![0.0; known.len()], part, boxes, pairs, from });
        Assigned { places, domain, warm }
    }

    /// The positions of the domain's bodies in the global block order, for the order of rows.
    fn places(&self, members: &Members, shared: Sharing, walls: usize) -> (Places, domain::Domain) {
        let (among, count) = (|body: &u32| members.known[*body as usize].place, members.len() as u32);
        let mut by_place: Vec<u32> = (0..count).collect();
        by_place.sort_unstable_by_key(among);
        let mut place = vec![0; count as usize];
        (0..).zip(&by_place).for_each(|(at, body)| place[*body as usize] = at);
        place.extend((0..walls as u32).map(|wall| count + wall));
        let of_walls = (0..walls as u32).map(|wall| shared.all as u32 + wall);
        let among_all: Vec<u32> = by_place.iter().map(among).chain(of_walls).collect();
        let known = &among_all[..count as usize];
        let edge = |edge: &u32| known.partition_point(|place| place < edge);
        let own = &shared.blocks[self.processes.rank()];
        let owner = by_place.iter().map(|body| members.owner[*body as usize]);
        let domain = domain::Domain {
            processes: self.processes,
            own: edge(&shared.edges[own.start])..edge(&shared.edges[own.end]),
            owner: owner.chain((0..walls).map(|_| u32::MAX)).collect(),
            bodies: shared.all + walls,
            blocks: shared.blocks,
            among_all: among_all.clone(),
            edges: shared.edges.clone(),
        };
        let blocks = shared.edges.iter().map(|at| edge(at) as u32).collect();
        (Places { place, blocks }, domain)
    }

    /// Whether the bodies of all processes, with these boxes, are still in their widened boxes. If not, the attempt
    /// will be retried.
    fn contains(&mut self, boxes: &[Aabb]) -> bool {
        let Some(step) = &mut self.step else { return true };
        let mut fits = true;
        for (i, aabb) in boxes.iter().enumerate().filter(|(i, aabb)| step.part.is_own(*i) && aabb.is_proper()) {
            let stored = &step.boxes[i];
            let beyond = (stored.min - aabb.min).max(aabb.max - stored.max).max_element();
            step.went[i] = step.went[i].max(step.part.way[i] + beyond);
            fits &= stored.contains(aabb);
        }
        let mut all = vec![0_u64; self.processes.size()];
        self.processes.all_gather_even(&[u64::from(!fits)], &mut all);
        if all.iter().all(|beyond| *beyond == 0) {
            return true;
        }
        // The retry begins with the former owners.
        let mut lists = vec![Vec::new(); self.processes.size()];
        for (i, from) in step.part.own().zip(&step.from) {
            let way = step.part.way[i].max(MARGIN * step.went[i]);
            lists[*from as usize].extend([u64::from(step.part.members[i]), way.to_bits()]);
        }
        let come = self.processes.all_to_all(lists).concat();
        let ways = come.as_chunks::<2>().0.iter().map(|[body, way]| (*body as u32, f64::from_bits(*way)));
        self.ways = ways.collect();
        self.retry = true;
        false
    }

    /// All bodies of the step and their velocities, gathered from the domains.
    fn all_moving(&self, bodies: &Bodies, twist: &[Twist]) -> Option<(Bodies, Vec<Twist>)> {
        let Step { part, .. } = self.step.as_ref()?;
        let mut moving = bodies.clone();
        for (i, Twist { linear, angular }) in twist.iter().enumerate() {
            (moving.velocity[i], moving.angular_velocity[i]) = (*linear, *angular);
        }
        let all = part.gather(self.processes, &moving);
        let twists = (0..all.len()).map(|i| all.twist(i)).collect();
        Some((all, twists))
    }
}
