//! Members of a team that are processes: what they exchange, by messages.
//!
//! Every process has the whole problem and takes the same decisions, and iterates on its own rows only. A product takes
//! two messages between two processes whose rows share bodies: multipliers one way, velocities the other. A sum is what
//! all chunks come to, from all processes. Where the iterations pause, all processes take all vectors, so that each has
//! what one process alone would have.

use super::member::{Member, Parts};
use super::shared::{Board, Exchange};
use super::{Method, Share, share};
use crate::lcp::Status;
use crate::lcp::cpu::Cpu;
use crate::lcp::drive::{Course, Drive, Standing};
use crate::lcp::verbs::Verbs;
use crate::processes::{Parcel, Processes};
use std::cell::RefCell;

/// Fewest rows for each process. An iteration on so many takes some 10 microseconds, and its six exchanges as much
/// where a message takes two. Where there are more processes than that, the last ones have no rows and only follow the
/// sums.
const LEAST_ROWS: usize = 768;

/// Whether so many rows are enough for two processes.
pub(super) fn pays(rows: usize) -> bool {
    rows >= 2 * LEAST_ROWS
}

/// The numbers that a process has of the others, and how it gets them.
struct Distant<const D: usize> {
    processes: Processes,
    board: Board,
    rows: RefCell<Post>,
    velocities: RefCell<Post>,
    /// The chunks of every process.
    chunks: Vec<usize>,
    first_chunk: usize,
}

/// Places whose numbers go to other processes, and come from them, with room for the numbers.
#[derive(Default)]
struct Post {
    out: Route,
    into: Route,
}

#[derive(Default)]
struct Route {
    places: Vec<Vec<u32>>,
    parcels: Vec<Parcel>,
}

impl Route {
    /// From pairs of a process and a place.
    fn new(mut places: Vec<(usize, u32)>, numbers: usize) -> Self {
        places.sort_unstable();
        places.dedup();
        let mut route = Route::default();
        for of_one in places.chunk_by(|a, b| a.0 == b.0) {
            route.places.push(of_one.iter().map(|(_, place)| *place).collect());
            route.parcels.push((of_one[0].0, vec![0.0; numbers * of_one.len()]));
        }
        route
    }
}

/// The range that a place is in, of ranges whose ends ascend.
fn owner(ranges: &[std::ops::Range<usize>], place: u32) -> usize {
    ranges.partition_point(|range| range.end <= place as usize)
}

impl<const D: usize> Distant<D> {
    fn new(processes: Processes, [rows, bodies]: [usize; 2], parts: &Parts) -> Self {
        let chunks: Vec<usize> = parts.chunks.iter().map(|of| of.len()).collect();
        Distant {
            processes,
            board: Board::new(rows, D * bodies, chunks.iter().sum()),
            rows: RefCell::default(),
            velocities: RefCell::default(),
            first_chunk: parts.chunks[processes.rank()].start,
            chunks,
        }
    }

    /// Settles who sends what to whom: a process sends the multipliers of its rows to the owners of their larger
    /// bodies, and these send the bodies' velocities back.
    fn route(&self, parts: &Parts, [across, before]: [Vec<(u32, u32)>; 2]) {
        let of_body = |(row, body): &(u32, u32)| (owner(&parts.bodies, *body), *row, *body);
        let of_row = |(row, body): &(u32, u32)| (owner(&parts.rows, *row), *row, *body);
        let (out, into): (Vec<_>, Vec<_>) = (across.iter().map(of_body).collect(), before.iter().map(of_row).collect());
        let by_row =
            |list: &[(usize, u32, u32)]| Route::new(list.iter().map(|(who, row, _)| (*who, *row)).collect(), 1);
        let by_body =
            |list: &[(usize, u32, u32)]| Route::new(list.iter().map(|(who, _, body)| (*who, *body)).collect(), D);
        *self.rows.borrow_mut() = Post { out: by_row(&out), into: by_row(&into) };
        *self.velocities.borrow_mut() = Post { out: by_body(&into), into: by_body(&out) };
    }

    fn swap<const N: usize>(&self, post: &RefCell<Post>, get: impl Fn(usize) -> [f64; N], put: impl Fn(usize, &[f64])) {
        let Post { out, into } = &mut *post.borrow_mut();
        for (places, (_, numbers)) in out.places.iter().zip(&mut out.parcels) {
            for (place, to) in places.iter().zip(numbers.as_chunks_mut::<N>().0) {
                *to = get(*place as usize);
            }
        }
        self.processes.swap(&out.parcels, &mut into.parcels);
        for (places, (_, numbers)) in into.places.iter().zip(&into.parcels) {
            for (place, from) in places.iter().zip(numbers.as_chunks::<N>().0) {
                put(*place as usize, from);
            }
        }
    }
}

impl<const D: usize> Exchange for Distant<D> {
    fn board(&self) -> &Board {
        &self.board
    }

    fn meet_for_rows(&self) {
        let x = &self.board.x;
        self.swap(&self.rows, |row| [x.get(row)], |row, number| x.put(row, number));
    }

    fn meet_for_velocities(&self) {
        let velocity = &self.board.velocity;
        self.swap(&self.velocities, |body| velocity.block::<D>(D * body), |body, v| velocity.put(D * body, v));
    }

    fn meet_for_sums(&self, turn: usize, of_chunk: usize) {
        let sums = &self.board.sums[turn];
        let numbers = |chunks: usize| of_chunk * chunks;
        let (first, own) = (numbers(self.first_chunk), numbers(self.chunks[self.processes.rank()]));
        let own: Vec<f64> = (first..first + own).map(|place| sums.get(place)).collect();
        let counts: Vec<usize> = self.chunks.iter().map(|chunks| numbers(*chunks)).collect();
        let mut all = vec![0.0; counts.iter().sum()];
        self.processes.gather_into(&own, &counts, &mut all);
        sums.put(0, &all);
    }
}

/// [`Drive::go`] on all processes.
pub(super) fn together<const D: usize>(
    processes: Processes,
    cpu: &mut Cpu<D>,
    drive: &mut Drive<Vec<f64>>,
    method: &mut Method,
    course: &mut Course<f64>,
    pauses: &impl Fn(Standing) -> bool,
) -> Option<Status> {
    let whole = cpu.whole();
    let size = [drive.at.x.len(), whole.incidence.start.len() - 1];
    let mut parts = Parts::new(&whole, processes.size().min(size[0] / LEAST_ROWS).max(1));
    parts.add_empty(processes.size());
    let distant = Distant::<D>::new(processes, size, &parts);
    let Some(mut member) = Member::of_one(whole, &distant, &parts, processes.rank()) else {
        return drive.go(cpu, method, course, 1, pauses);
    };
    distant.route(&parts, member.borders());
    let Share { drive: mut own_drive, method: mut own_method, course: mut own_course } =
        share(&member, drive, method, course);
    own_drive.history = drive.history.take();
    let ended = own_drive.go(&mut member, &mut own_method, &mut own_course, 1, pauses);
    let (rows, products) = (member.rows.clone(), member.products());
    drop(member);
    drive.take_back(rows.clone(), &own_drive);
    method.take_back(rows, &own_method);
    let counts: Vec<usize> = parts.rows.iter().map(|rows| rows.len()).collect();
    let of_drive = drive.shared().into_iter().zip(own_drive.shared());
    for (all, own) in of_drive.chain(method.shared().into_iter().zip(own_method.shared())) {
        processes.gather_into(own, &counts, all);
    }
    drive.history = own_drive.history;
    *course = own_course;
    cpu.count(products - cpu.products_made());
    ended
}
