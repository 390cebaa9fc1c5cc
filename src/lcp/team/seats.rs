//! What the members of a team keep from one round of a solve to the next: their parts of all vectors, and what connects
//! their rows. Each member makes its own, at the same time as the others.

use super::Method;
use super::member::{Links, Member, Parts};
use super::shared::Shared;
use crate::lcp::Status;
use crate::lcp::cpu::{Cpu, Whole};
use crate::lcp::drive::{Drive, Progress, ResidualSample, SolveState};
use crate::lcp::pair_blocks::Part;
use crate::lcp::portion::Portion;
use crate::lcp::verbs::Verbs;

/// The seats of a team; none between two solves and while one thread iterates alone.
pub(super) struct Seats<const D: usize> {
    team: Option<Seated<D>>,
}

/// A team between two rounds.
struct Seated<const D: usize> {
    shared: Shared,
    parts: Parts,
    /// None before its member has come.
    seats: Vec<Option<Seat<D>>>,
}

/// A member between two rounds.
struct Seat<const D: usize> {
    links: Links<D>,
    drive: Drive<Vec<f64>>,
    method: Method,
    state: SolveState<f64>,
}

/// A solve where one thread left it.
#[derive(Clone, Copy)]
struct Left<'a> {
    drive: &'a Drive<Vec<f64>>,
    method: &'a Method,
    state: &'a SolveState<f64>,
}

/// How a member's round ended: its status, and the products made.
type Ended = (Option<Status>, u64);

impl<const D: usize> Seats<D> {
    pub fn none() -> Self {
        Seats { team: None }
    }

    /// Gives all parts of vectors back, for one thread.
    pub fn leave(&mut self, drive: &mut Drive<Vec<f64>>, method: &mut Method) {
        let Some(Seated { parts, seats, .. }) = self.team.take() else { return };
        for (rows, seat) in parts.rows.into_iter().zip(&seats) {
            if let Some(seat) = seat {
                drive.take_back(rows.clone(), &seat.drive);
                method.take_back(rows, &seat.method);
            }
        }
    }

    /// [`Drive::go`] on this many threads, if all of them start. Only the iterate and the gradient are given back.
    pub fn go<P: Portion<D>>(
        &mut self,
        members: usize,
        cpu: &mut Cpu<D, P>,
        drive: &mut Drive<Vec<f64>>,
        method: &mut Method,
        state: &mut SolveState<f64>,
        pauses: &(impl Fn(Progress) -> bool + Sync),
    ) -> Option<Option<Status>> {
        if self.team.as_ref().is_some_and(|team| team.seats.len() != members) {
            self.leave(drive, method);
        }
        let mut whole = cpu.whole();
        let blocks = whole.blocks.take();
        let team = self.team.get_or_insert_with(|| Seated::new(&whole, members));
        team.shared.form();
        let mut history = drive.history.take();
        let ended = match blocks {
            Some(blocks) => team.run(&whole, blocks, Left { drive, method, state }, &mut history, pauses),
            None => None,
        };
        drive.history = history;
        let Some((status, products)) = ended else {
            let noted = std::mem::take(&mut whole.noted);
            cpu.put_back(noted);
            self.leave(drive, method);
            return None;
        };
        cpu.count(products - cpu.products_made());
        team.show(drive, state);
        Some(status)
    }
}

impl<const D: usize> Seated<D> {
    fn new(whole: &Whole<'_, D>, members: usize) -> Self {
        let bodies = whole.incidence.start.len() - 1;
        let shared = Shared::new(members, whole.q.len(), D * bodies, whole.chunks.len());
        Seated { shared, parts: Parts::new(whole, members), seats: (0..members).map(|_| None).collect() }
    }

    /// A round of all members.
    fn run(
        &mut self,
        whole: &Whole<'_, D>,
        blocks: Part<'_>,
        left: Left<'_>,
        history: &mut Option<Vec<ResidualSample>>,
        pauses: &(impl Fn(Progress) -> bool + Sync),
    ) -> Option<Ended> {
        let Seated { shared, parts, seats } = self;
        let (shared, parts) = (&*shared, &*parts);
        let work = |k: usize, blocks, seat: &mut Option<Seat<D>>, history: &mut Option<Vec<ResidualSample>>| {
            let _guard = shared.guard();
            let mut sits = seat.take().unwrap_or_else(|| Seat::new(whole, (parts, k), left));
            sits.drive.history = history.take();
            let mut member = Member::new(whole, shared, (parts, k), blocks, sits.links);
            let ended = sits.drive.go(&mut member, &mut sits.method, &mut sits.state, 1, pauses);
            *history = sits.drive.history.take();
            let products = member.products();
            *seat = Some(Seat { links: member.into_links(), ..sits });
            (ended, products)
        };
        let mut rest = Some(blocks);
        let mut blocks_of = |k: usize| {
            let (own, others) = rest.take()?.split_at(parts.chunks[k].len());
            rest = Some(others);
            Some(own)
        };
        rayon::scope(|scope| {
            let mut all = seats.iter_mut().enumerate();
            let first = all.next().and_then(|(k, seat)| Some((k, blocks_of(k)?, seat)));
            for (k, seat) in all {
                let (work, blocks) = (&work, blocks_of(k));
                scope.spawn(move |_| {
                    if let Some(blocks) = blocks.filter(|_| shared.join()) {
                        work(k, blocks, seat, &mut None);
                    }
                });
            }
            first.filter(|_| shared.gather()).map(|(k, blocks, seat)| work(k, blocks, seat, history))
        })
    }

    /// Copies the iterate, its gradient and the state of the solve.
    fn show(&self, drive: &mut Drive<Vec<f64>>, state: &mut SolveState<f64>) {
        for (rows, seat) in self.parts.rows.iter().zip(self.seats.iter().flatten()) {
            drive.at.x[rows.clone()].copy_from_slice(&seat.drive.at.x);
            drive.at.g[rows.clone()].copy_from_slice(&seat.drive.at.g);
        }
        if let Some(seat) = self.seats.iter().flatten().next() {
            state.clone_from(&seat.state);
        }
    }
}

impl<const D: usize> Seat<D> {
    /// Member `k`'s part of a solve.
    fn new(whole: &Whole<'_, D>, (parts, k): (&Parts, usize), Left { drive, method, state }: Left<'_>) -> Self {
        let rows = parts.rows[k].clone();
        let (drive, method) = (drive.share(rows.clone()), method.share(rows));
        Seat { links: Links::new(whole, parts, k), drive, method, state: state.clone() }
    }
}
