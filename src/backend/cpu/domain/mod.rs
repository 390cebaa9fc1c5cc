//! A process's domain of a step that several processes take: some blocks of near bodies ([`crate::bisection`]), and the
//! bodies of others that its own may meet in the step, its halo.
//!
//! Between two steps a process has its own bodies and copies of those that their pairs are with (`part`). It grows its
//! own; all processes number the daughters together (`births`). Then all bodies are cut into blocks anew (`order`),
//! go to the processes that have their blocks from now on (`sharing`), and to those whose bodies they may meet
//! (`halo`). Each process takes the step with its domain and halo as one process takes a step of all bodies. A pair
//! with an own body is its pair, so that a pair across a border is with both. Exchanged are velocities of bodies in
//! others' halos, and numbers of all (`lcp::domain`; faults, overlaps). Whoever asks for the state gathers it.
//!
//! The halo is sound: each body's box with half the cutoff is widened by its own way, which is somewhat more than it
//! went last. Two bodies whose widened boxes do not touch cannot meet while both stay in them, of whatever size they
//! are. The owner of a body sees whether it does. Where one did not, all take the step anew with wider boxes.

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
pub(crate) use team::{Given, shares};

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
/// its five exchanges as much where a message takes one to two. Where there are more processes than that, the last ones
/// have no bodies and only follow the sums.
const LEAST_BODIES: usize = 2 * MOST_IN_A_BLOCK;

/// How much farther than in the last step a body may go before the step is made anew. It changes no result.
const MARGIN: f64 = 1.5;

/// The processes that take steps together, and what this one has of them: a [`Team`](super::team::Team) of several.
pub struct Domain {
    processes: Processes,
    /// Whether steps may be shared out; else each process takes them alone.
    shares: bool,
    /// What this process has of the last accepted state; none where all processes have all of it.
    part: Option<Part>,
    step: Option<Step>,
    /// Steps are taken by everyone alone.
    resting: bool,
    /// Whether the present attempt is to be made anew, and how far bodies may go then, by their numbers.
    anew: bool,
    ways: BTreeMap<u32, f64>,
    /// The bodies that the present attempt begins with, and the mothers of those that are new: of own bodies.
    births: Births,
    dividing: Vec<Divided>,
    /// The mothers that divided in the last step, where that was shared out.
    divided: Option<Vec<Divided>>,
    /// The whole state where someone has asked for it: of rank 0, and the bodies on all processes.
    gathered: OnceLock<State>,
    everywhere: OnceLock<Bodies>,
    /// The lines of all bodies before the last step, where that began with parts and ended whole.
    lines_before: Option<Vec<Lineage>>,
}

/// A step that is shared out.
struct Step {
    part: Part,
    boxes: Vec<Aabb>,
    pairs: Vec<[u32; 2]>,
    /// Which processes had the own bodies before, in their order.
    from: Vec<u32>,
    /// How far own bodies went beyond what they would fill at rest.
    went: Vec<f64>,
}

/// What a process has taken up of a step.
struct Taken {
    places: Places,
    domain: domain::Domain,
    warm: Vec<Warm>,
}

/// How many processes share so many bodies; none where that is not worth it.
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
            resting: false,
            anew: false,
            ways: BTreeMap::new(),
            births: Births::default(),
            dividing: Vec::new(),
            divided: None,
            gathered: OnceLock::new(),
            everywhere: OnceLock::new(),
            lines_before: None,
        }
    }

    /// The number of a body of the domain among all bodies.
    fn number(&self, body: usize) -> usize {
        self.step.as_ref().map_or(body, |step| step.part.members[body] as usize)
    }

    /// How many processes share the next step, if that is worth it.
    fn sharing(&self, state: &State) -> Option<usize> {
        let bodies = self.part.as_ref().map_or(state.bodies.len(), |part| part.all);
        among(self.processes, bodies).filter(|_| self.shares && !self.resting)
    }

    /// Begins a step: each process has a part of the state where it is to be shared out, else all of it. Says which.
    fn take_up(&mut self, state: &mut State) -> bool {
        (self.step, self.anew) = (None, false);
        self.forget_gathered();
        if self.sharing(state).is_none() {
            self.make_whole(state);
            return false;
        }
        self.part.get_or_insert_with(|| Part::of_whole(self.processes, state));
        true
    }

    /// What is remembered of pairs, by the places of their bodies in the part.
    fn by_place(&self, warm: &[Warm]) -> Vec<Warm> {
        self.part.as_ref().map_or_else(Vec::new, |part| part.by_place(warm))
    }

    /// Leaves of the bodies of `start` those of this process, which it grows.
    fn leave_own(&self, start: &mut Start) {
        let Some(part) = &self.part else { return };
        let own: Vec<bool> = (0..part.members.len()).map(|i| part.is_own(i)).collect();
        start.bodies.retain(&own);
        kept(&mut start.pressures, &own);
    }

    /// Shares out the step that begins with the own bodies of all processes in `start`: leaves of them what is for this
    /// process, with its halo, and of what is remembered too.
    fn share(&mut self, setup: &Setup, start: &mut Start, state: &State) -> Option<Taken> {
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
        let here = (numbers.as_slice(), &bodies);
        let shared = Sharing::new(processes, here, start.periods, &work, (sharing, all));
        let warm = shared.hand_over(processes, part, &state.warm);
        let (own, from) = shared.send(processes, here, &way, &start.pressures);
        let own = Members::new(own, &bodies);
        let bonded = !setup.bonds.is_empty() && !start.parting;
        let bonds = if bonded { setup.bonds.holding(&bodies.broken_bonds) } else { Vec::new() };
        let halo = Halo::new(processes, own, start.periods, setup.cutoff, &bonds);
        Some(self.take(halo, from, (shared, warm, setup.walls.len()), start))
    }

    /// Takes up a domain with its halo.
    fn take(
        &mut self,
        halo: Halo,
        from: Vec<u32>,
        (shared, warm, walls): (Sharing, Vec<Warm>, usize),
        start: &mut Start,
    ) -> Taken {
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
        start.pressures = known.iter().map(|known| known.pressure).collect();
        log::debug!(
            "process {rank}: {} bodies of {} and {} in the halo, {} pairs",
            from.len(),
            part.all,
            known.len() - from.len(),
            pairs.len()
        );
        let warm = part.by_place(&warm);
        self.step = Some(Step { went: vec![0.0; known.len()], part, boxes, pairs, from });
        Taken { places, domain, warm }
    }

    /// Where the bodies of the domain stand among all, for the order of rows.
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

    /// Whether all bodies of all processes, whose boxes these are now, are in their widened boxes; where some are not,
    /// the attempt is to be made anew.
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
        self.processes.gather_even(&[u64::from(!fits)], &mut all);
        if all.iter().all(|beyond| *beyond == 0) {
            return true;
        }
        // The attempt begins where bodies were before it.
        let mut lists = vec![Vec::new(); self.processes.size()];
        for (i, from) in step.part.own().zip(&step.from) {
            let way = step.part.way[i].max(MARGIN * step.went[i]);
            lists[*from as usize].extend([u64::from(step.part.members[i]), way.to_bits()]);
        }
        let come = self.processes.deliver(lists).concat();
        let ways = come.as_chunks::<2>().0.iter().map(|[body, way]| (*body as u32, f64::from_bits(*way)));
        self.ways = ways.collect();
        self.anew = true;
        false
    }

    /// All bodies of the step, and the velocities of all, from those of the domains.
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
