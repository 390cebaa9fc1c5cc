//! A process's domain of a step that several processes take: some blocks of near bodies ([`crate::bisection`]), and the
//! bodies of others that its own may meet in the step, its halo.
//!
//! Bodies are all on all processes between two steps: growth, division and removal are everybody's. In a step each
//! process has the bodies of its domain and halo alone, in the order of all of them, and takes it as one process takes
//! a step of all bodies. A pair with an own body is its pair, so that a pair across a border is with both. Exchanged
//! are velocities of bodies in others' halos, and numbers of all (`lcp::domain`; faults, overlaps). What a step
//! leaves of pairs stays with the owners of their bodies; it is gathered when someone asks for the state.
//!
//! The halo is sound: each body's box with half the cutoff is widened by its own way, which is somewhat more than it
//! went last. Two bodies whose widened boxes do not touch cannot meet while both stay in them, of whatever size they
//! are. The owner of a body sees whether it does. Where one did not, all take the step anew with wider boxes.

mod halo;
mod known;
mod troubles;

pub(super) use troubles::Trouble;

use super::setup::Setup;
use super::start::Start;
use crate::bisection::{Blocks, MOST_IN_A_BLOCK, bisect};
use crate::bodies::Bodies;
use crate::dynamics::{Incidence, Pose, Twist};
use crate::lcp::Places;
use crate::lcp::domain;
use crate::motion::Aabb;
use crate::processes::Processes;
use crate::step::{Fault, State};
use crate::warm::Warm;
use halo::Halo;
use known::Known;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Fewest bodies for each process: two blocks. An iteration on the rows of so many cells takes some 8 microseconds, and
/// its five exchanges as much where a message takes one to two. Where there are more processes than that, the last ones
/// have no bodies and only follow the sums.
const LEAST_BODIES: usize = 2 * MOST_IN_A_BLOCK;

/// How much farther than in the last step a body may go before the step is made anew. It changes no result.
const MARGIN: f64 = 1.5;

/// What a step is shared out by.
pub(super) struct Domain {
    pub(super) processes: Processes,
    /// What is known of the bodies from the last shared step; none where all is known of them.
    known: Option<Known>,
    step: Option<Step>,
    /// Steps are taken by everyone alone.
    pub(super) resting: bool,
    /// Whether the present attempt is to be made anew, with these ways.
    anew: Option<Vec<f64>>,
    /// The state with all that is remembered of pairs, once someone has asked for it.
    gathered: OnceLock<State>,
}

/// A step that is shared out.
struct Step {
    /// All bodies, grown.
    all: Bodies,
    pressures: Vec<f64>,
    bonds: Option<Incidence>,
    known: Known,
    halo: Halo,
    /// How far own bodies went beyond what they would fill at rest.
    went: Vec<f64>,
}

impl Domain {
    #[cfg(feature = "mpi")]
    pub(super) fn new(processes: Processes) -> Self {
        Domain { processes, known: None, step: None, resting: false, anew: None, gathered: OnceLock::new() }
    }

    /// Whether the present step is shared out.
    pub(super) fn is_shared(&self) -> bool {
        self.step.is_some()
    }

    /// The number of a body of the domain among all bodies.
    pub(super) fn number(&self, body: usize) -> usize {
        self.step.as_ref().map_or(body, |step| step.halo.members[body] as usize)
    }

    /// Shares out the step that begins with the bodies of `start`, if that is worth it: leaves of them what is for this
    /// process, and of what is remembered too.
    pub(super) fn share_out(
        &mut self,
        setup: &Setup,
        start: &mut Start,
        state: &mut State,
    ) -> Option<(Places, Vec<Warm>)> {
        self.step = None;
        self.gathered = OnceLock::new();
        let bodies = start.bodies.len();
        let sharing = self.processes.size().min(bodies / LEAST_BODIES);
        if self.resting || sharing < 2 {
            self.make_whole(state);
            return None;
        }
        let blocks = bisect(&start.bodies.position, start.periods);
        let all = std::mem::take(&mut start.bodies);
        let mut known = self.known.as_ref().map_or_else(|| Known::nothing(&all), |known| known.grown(&all));
        if let Some(way) = self.anew.take().filter(|way| way.len() == bodies) {
            known.way = way;
        }
        let before = self.known.as_ref().map(|known| known.owner.as_slice());
        let shares = share(&blocks, &known.work, sharing, self.processes.size());
        known.own(&blocks, &shares);
        let bonded = !setup.bonds.is_empty() && !start.parting;
        let bonds = bonded.then(|| setup.bonds.incidence(&all.lineage, &all.broken_bonds));
        let halo = Halo::new(self.processes.rank(), &all, start.periods, &known, setup.cutoff, bonds.as_ref());
        self.log(&known, &halo, sharing);
        start.bodies = halo.cut(&all);
        start.foreign = halo.own.iter().map(|own| !own).collect();
        let pressures = std::mem::take(&mut start.pressures);
        start.pressures = halo.members.iter().filter_map(|body| pressures.get(*body as usize).copied()).collect();
        let warm = self.hand_over(&halo, &known.owner, before, &state.warm);
        let places = self.places(&blocks, shares, &halo, &known.owner, setup.walls.len());
        let went = vec![0.0; halo.members.len()];
        self.step = Some(Step { all, pressures, bonds, known, halo, went });
        Some((places, warm))
    }

    fn log(&self, known: &Known, halo: &Halo, sharing: usize) {
        let rank = self.processes.rank() as u32;
        let of = |body: &usize| known.owner[*body] == rank;
        let own: f64 = (0..known.owner.len()).filter(of).map(|body| known.work[body]).sum();
        let mean = known.work.iter().sum::<f64>() / sharing as f64;
        let (members, bodies) = (halo.members.len(), halo.own.iter().filter(|own| **own).count());
        log::debug!(
            "process {rank}: {bodies} bodies of {} and {} in the halo, {:.3} of the mean work, {} pairs",
            known.owner.len(),
            members - bodies,
            own / mean,
            halo.pairs.len()
        );
    }

    /// Where the bodies of the domain stand among all, for the order of rows.
    fn places(&self, blocks: &Blocks, shares: Vec<Range<usize>>, halo: &Halo, owner: &[u32], walls: usize) -> Places {
        let (among, all) = (blocks.places(), owner.len() as u32);
        let members = halo.members.len() as u32;
        let mut by_place: Vec<u32> = (0..members).collect();
        by_place.sort_unstable_by_key(|body| among[halo.members[*body as usize] as usize]);
        let mut place = vec![0; members as usize];
        (0..).zip(&by_place).for_each(|(at, body)| place[*body as usize] = at);
        place.extend((0..walls as u32).map(|wall| members + wall));
        let of = |body: &u32| halo.members[*body as usize] as usize;
        let among_all = by_place.iter().map(|body| among[of(body)]).chain((0..walls as u32).map(|wall| all + wall));
        let among_all: Vec<u32> = among_all.collect();
        let known = &among_all[..members as usize];
        let edge = |edge: &u32| known.partition_point(|place| place < edge);
        let own = &shares[self.processes.rank()];
        let domain = domain::Domain {
            processes: self.processes,
            own: edge(&blocks.edges[own.start])..edge(&blocks.edges[own.end]),
            owner: by_place.iter().map(|body| owner[of(body)]).chain((0..walls).map(|_| u32::MAX)).collect(),
            bodies: owner.len() + walls,
            edges: blocks.edges.clone(),
            blocks: shares,
            among_all: among_all.clone(),
        };
        Places {
            place,
            blocks: blocks.edges.iter().map(|at| edge(at) as u32).collect(),
            domain: Some(Arc::new(domain)),
        }
    }

    /// The pairs of the domain that may be near, where all bodies are in their widened boxes: `boxes` are those of its
    /// bodies now.
    ///
    /// # Errors
    /// Where some body of some process is not. The attempt is then made anew.
    pub(super) fn candidates(&mut self, boxes: &[Aabb]) -> Result<&[[u32; 2]], Fault> {
        let Some(step) = &mut self.step else { return Ok(&[]) };
        let mut fits = true;
        for (i, aabb) in boxes.iter().enumerate().filter(|(i, aabb)| step.halo.own[*i] && aabb.is_proper()) {
            let stored = &step.halo.boxes[i];
            let beyond = (stored.min - aabb.min).max(aabb.max - stored.max).max_element();
            let way = step.known.way[step.halo.members[i] as usize];
            step.went[i] = step.went[i].max(way + beyond);
            fits &= stored.contains(aabb);
        }
        let mut all = vec![0_u64; self.processes.size()];
        self.processes.gather_even(&[u64::from(!fits)], &mut all);
        if all.iter().all(|beyond| *beyond == 0) {
            return Ok(&step.halo.pairs);
        }
        let (halo, mut way) = (&step.halo, step.known.way.clone());
        let went = |body: usize| [halo.place(body).map_or(0.0, |i| step.went[i])];
        known::spread(self.processes, &step.known.owner, went, |body, [went]| way[body] = way[body].max(MARGIN * went));
        self.anew = Some(way);
        Err(Fault::Processes("a body went farther than the others know".into()))
    }

    /// Whether the present attempt is to be made anew.
    pub(super) fn begins_anew(&self) -> bool {
        self.anew.is_some()
    }

    /// Gives others what they need of own bodies, and takes what is needed of theirs.
    pub(super) fn exchange<const N: usize>(&self, of_body: &mut [[f64; N]]) {
        let Some(Step { halo, .. }) = &self.step else { return };
        let pack = |places: &[u32]| places.iter().flat_map(|body| of_body[*body as usize]).collect();
        let out: Vec<(usize, Vec<f64>)> = halo.out.iter().map(|(to, places)| (*to, pack(places))).collect();
        let room = |(from, places): &(usize, Vec<u32>)| (*from, vec![0.0; N * places.len()]);
        let mut into: Vec<(usize, Vec<f64>)> = halo.into.iter().map(room).collect();
        self.processes.swap(&out, &mut into, || {});
        for ((_, places), (_, numbers)) in halo.into.iter().zip(&into) {
            places
                .iter()
                .zip(numbers.as_chunks::<N>().0)
                .for_each(|(body, numbers)| of_body[*body as usize] = *numbers);
        }
    }

    /// All bodies of the step, and the velocities of all, from those of the domain.
    pub(super) fn all_moving(&self, twist: &[Twist]) -> Option<(&Bodies, Vec<Twist>)> {
        let Step { all, halo, known, .. } = self.step.as_ref()?;
        let own = |body: usize| {
            let twist = halo.place(body).map_or(Twist::default(), |i| twist[i]);
            let ([a, b, c], [d, e, f]) = (twist.linear.to_array(), twist.angular.to_array());
            [a, b, c, d, e, f]
        };
        let mut twists = vec![Twist::default(); all.len()];
        known::spread(self.processes, &known.owner, own, |body, [a, b, c, d, e, f]| {
            twists[body] = Twist { linear: [a, b, c].into(), angular: [d, e, f].into() };
        });
        Some((all, twists))
    }

    /// Grows all bodies over the second half of a step.
    pub(super) fn lengthen(&mut self, grow: impl FnOnce(&mut Bodies, &[f64])) {
        if let Some(step) = &mut self.step {
            grow(&mut step.all, &step.pressures);
        }
    }

    /// All bodies where those of the domain arrive, and with what each process knows of its own; `rows` are the first
    /// bodies of its rows.
    pub(super) fn arrive(
        &mut self,
        setup: &Setup,
        at: (&[Pose], &[Twist]),
        rows: impl Iterator<Item = u32>,
    ) -> Option<Bodies> {
        let Step { mut all, bonds, mut known, halo, went, .. } = self.step.take()?;
        let mut work = vec![known::WORK_OF_A_BODY; halo.members.len()];
        rows.for_each(|body| work[body as usize] += 1.0);
        let own = |body: usize| {
            let Some(i) = halo.place(body) else { return [0.0; 15] };
            let (Pose { position, orientation }, twist) = (at.0[i], at.1[i]);
            let ([x, y, z], [p, q, r, s]) = (position.to_array(), orientation.to_array());
            let ([a, b, c], [d, e, f]) = (twist.linear.to_array(), twist.angular.to_array());
            [x, y, z, p, q, r, s, a, b, c, d, e, f, work[i], went[i]]
        };
        let Known { owner, work: of_work, way } = &mut known;
        known::spread(self.processes, owner, own, |body, [x, y, z, p, q, r, s, a, b, c, d, e, f, work, went]| {
            all.position[body] = [x, y, z].into();
            all.orientation[body] = glam::DQuat::from_array([p, q, r, s]);
            all.velocity[body] = [a, b, c].into();
            all.angular_velocity[body] = [d, e, f].into();
            of_work[body] = work;
            way[body] = MARGIN * went;
        });
        if let Some(bonds) = &bonds {
            setup.bonds.find_broken(bonds, &mut all);
        }
        self.known = Some(known);
        Some(all)
    }
}

/// The blocks of each process: consecutive ones, of about the same work, for the first `sharing` of all.
fn share(blocks: &Blocks, work: &[f64], sharing: usize, all: usize) -> Vec<Range<usize>> {
    let of_block = |ends: &[u32]| -> f64 {
        blocks.order[ends[0] as usize..ends[1] as usize].iter().map(|body| work[*body as usize]).sum()
    };
    let mut until = vec![0.0];
    for ends in blocks.edges.windows(2) {
        until.push(until[until.len() - 1] + of_block(ends));
    }
    let total = until[until.len() - 1];
    let edge = |process: usize| {
        if process >= sharing {
            return blocks.len();
        }
        let wanted = total * process as f64 / sharing as f64;
        let above = until.partition_point(|sum| *sum < wanted).clamp(1, blocks.len());
        let below = above - 1;
        let nearest = if until[above] - wanted < wanted - until[below] { above } else { below };
        // Each has a block at least.
        nearest.clamp(process, blocks.len() - (sharing - process))
    };
    (0..all).map(|process| edge(process)..edge(process + 1)).collect()
}
