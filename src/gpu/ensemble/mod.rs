//! Ensembles: many independent scenes, stepped on one device as if they were one.
//!
//! To the layers above, each member is a device of its own: a [`Gpu`] with buffers, kernels, recorders and read-backs.
//! One arena contains the buffers of all members. The commands that a member records are kept until it waits for a
//! result. Then the work of all waiting members is ordered, equal kernels together, and each dispatch serves all
//! members that request it (`merge`). So all members share the cost of a launch, a submission and a read-back.
//!
//! Members may differ: members that request other kernels, need more iterations, grow, end or fail only share fewer
//! dispatches. Every member computes the same as it does alone, with the same order of sums, so its bits depend neither
//! on the other members nor on the times at which rounds begin.
//!
//! A member that begins a step waits until no other member is within a step, so that members stay synchronised.

mod arena;
mod copies;
mod merge;
mod order;
mod pipeline;
mod round;
mod tables;
mod work;

#[cfg(test)]
pub(super) use merge::merged;
pub(super) use pipeline::Pipeline;
pub(super) use work::{Dispatch, Work};

use super::kernel_cache::KernelCache;
use super::lock::lock;
use super::{Gpu, GpuError};
use arena::Arena;
use round::Buffers;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use work::Request;

/// If no request has arrived for this long, a round begins without the members that are still at work on the host. A
/// member that writes a file or takes a step on the CPU must not delay the others; preparing the next request takes
/// less time.
const QUIET: Duration = Duration::from_millis(5);

/// Bytes of a member without bodies: some hundred buffers of one unit each. Members with three bodies take 330 kB.
const BYTES_OF_MEMBER: u64 = 400_000;

/// Bytes per body, with its pairs and rows: 2.6 kB at 2^20 bodies, and half as much again for buffers that grow.
const BYTES_OF_BODY: u64 = 4_000;

/// Statistics of an ensemble.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounds {
    /// The number of rounds; each is one submission and one read-back.
    pub rounds: u64,
    /// The number of members' requests that they served.
    pub requests: u64,
    /// Seconds spent on recording and executing rounds; `waited` is the time spent on waiting for members.
    pub seconds: f64,
    /// See `seconds`.
    pub waited: f64,
    /// Dispatches made; `asked` is the number that members requested.
    pub dispatches: u64,
    /// See `dispatches`.
    pub asked: u64,
    /// The largest number of bytes that the members' buffers held at once.
    pub peak_bytes: u64,
}

/// Many scenes on one device; see the module. After the ensemble is dropped, its thread serves the remaining members
/// until the last one is dropped.
pub struct Ensemble {
    core: Arc<Core>,
    conductor: Option<JoinHandle<()>>,
}

/// Data shared by the members and the conductor, the thread that serves them.
pub(super) struct Core {
    gpu: Arc<Gpu>,
    arena: Mutex<Arena>,
    kernels: KernelCache,
    board: Mutex<Board>,
    /// Notified when a member joins, leaves or makes a request.
    changed: Condvar,
    next: AtomicU64,
    rounds: Mutex<Rounds>,
}

/// The members and their states.
struct Board {
    seats: BTreeMap<u64, Seat>,
    /// The last time that a member joined, left or made a request.
    changed: Instant,
    closing: bool,
    /// Whether the conductor has ended.
    ended: bool,
}

struct Seat {
    stands: Stands,
    answered: Arc<Condvar>,
}

enum Stands {
    /// Works on the host and will soon make a request.
    AtWork,
    /// Makes no request for a while.
    Away,
    Asks(Request),
    /// Takes part in the present round.
    Served,
    Answered(Result<Vec<Vec<u8>>, GpuError>),
}

/// A member's connection to the ensemble, used by its device.
pub(super) struct Membership {
    core: Arc<Core>,
    id: u64,
    answered: Arc<Condvar>,
    pending: Mutex<Vec<Work>>,
    begins_step: AtomicBool,
}

impl Ensemble {
    /// An ensemble on a device. The device may also be used directly.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], or the fault that the device reported.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, GpuError> {
        let (arena, tables) = (Mutex::new(Arena::new(&gpu)?), Buffers::new(&gpu)?);
        let board = Board { seats: BTreeMap::new(), changed: Instant::now(), closing: false, ended: false };
        let core = Arc::new(Core {
            gpu,
            arena,
            kernels: KernelCache::default(),
            board: Mutex::new(board),
            changed: Condvar::new(),
            next: AtomicU64::new(1),
            rounds: Mutex::default(),
        });
        let conducted = core.clone();
        let conductor = std::thread::Builder::new()
            .name("ensemble".into())
            .spawn(move || conducted.conduct(tables))
            .map_err(|e| GpuError::Refused { message: format!("an ensemble needs a thread: {e}") })?;
        Ok(Ensemble { core, conductor: Some(conductor) })
    }

    /// A device for one more member. When it is dropped, it leaves the ensemble and its buffers are freed.
    pub fn member(&self) -> Arc<Gpu> {
        let id = self.core.next.fetch_add(1, Ordering::Relaxed);
        let answered = Arc::new(Condvar::new());
        let mut board = lock(&self.core.board);
        board.seats.insert(id, Seat { stands: Stands::AtWork, answered: answered.clone() });
        board.changed = Instant::now();
        drop(board);
        let core = self.core.clone();
        let membership =
            Membership { core, id, answered, pending: Mutex::default(), begins_step: AtomicBool::new(false) };
        Arc::new(self.core.gpu.of_member(membership))
    }

    /// The present number of members.
    pub fn members(&self) -> usize {
        lock(&self.core.board).seats.len()
    }

    /// The statistics so far.
    pub fn rounds(&self) -> Rounds {
        Rounds { peak_bytes: lock(&self.core.arena).peak, ..*lock(&self.core.rounds) }
    }

    /// The approximate number of members with this many bodies each that fit at once.
    pub fn members_that_fit(&self, bodies: u64) -> u64 {
        self.most_bytes() / (BYTES_OF_MEMBER + BYTES_OF_BODY * bodies)
    }

    /// The largest number of bytes of the buffers of all members together.
    pub fn most_bytes(&self) -> u64 {
        arena::most_bytes(&self.core.gpu)
    }
}

impl Drop for Ensemble {
    fn drop(&mut self) {
        let mut board = lock(&self.core.board);
        board.closing = true;
        let is_empty = board.seats.is_empty();
        drop(board);
        self.core.changed.notify_all();
        log::info!("ensemble: {:?}", self.rounds());
        // Remaining members are served until the last one leaves.
        if let Some(conductor) = self.conductor.take().filter(|_| is_empty) {
            // The thread has no result, and members see that it has ended.
            let _ = conductor.join();
        }
    }
}

/// Informs all members when the conductor ends, also after a panic.
struct Ends<'a>(&'a Core);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        let mut board = lock(&self.0.board);
        board.ended = true;
        board.seats.values().for_each(|seat| seat.answered.notify_all());
    }
}

impl Core {
    /// Serves members, round after round, until the ensemble has been dropped and the last member has left.
    fn conduct(&self, mut tables: Buffers) {
        let _ends = Ends(self);
        let mut idle = Instant::now();
        while let Some((ids, requests)) = self.next_round() {
            let (count, waited, begun) = (requests.len() as u64, idle.elapsed(), Instant::now());
            let answers = match round::run(&self.gpu, &self.arena, &mut tables, requests) {
                Ok((answers, done)) => {
                    let mut rounds = lock(&self.rounds);
                    rounds.rounds += 1;
                    rounds.requests += count;
                    rounds.dispatches += done.dispatches;
                    rounds.asked += done.asked;
                    rounds.seconds += begun.elapsed().as_secs_f64();
                    rounds.waited += waited.as_secs_f64();
                    answers.into_iter().map(Ok).collect()
                }
                Err(fault) => vec![Err(fault); ids.len()],
            };
            idle = Instant::now();
            let mut board = lock(&self.board);
            board.changed = Instant::now();
            for (id, answer) in ids.into_iter().zip(answers) {
                if let Some(seat) = board.seats.get_mut(&id) {
                    seat.stands = Stands::Answered(answer);
                    seat.answered.notify_all();
                }
            }
        }
    }

    /// Waits until a round may begin, and takes its requests.
    fn next_round(&self) -> Option<(Vec<u64>, Vec<Request>)> {
        let mut board = lock(&self.board);
        loop {
            let asks = |seat: &&Seat| matches!(seat.stands, Stands::Asks(_));
            let waiting = board.seats.values().filter(asks).count();
            let at_work =
                board.seats.values().filter(|seat| !asks(seat) && !matches!(seat.stands, Stands::Away)).count();
            if waiting == 0 {
                if board.closing && board.seats.is_empty() {
                    return None;
                }
                board = self.changed.wait(board).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            let quiet = board.changed.elapsed();
            if at_work == 0 || quiet >= QUIET {
                return Some(board.take());
            }
            board = self.changed.wait_timeout(board, QUIET - quiet).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// The merged kernels of the members.
    pub fn kernels(&self) -> &KernelCache {
        &self.kernels
    }
}

impl Board {
    /// Takes the requests of all members that wait within a step; if there are none, of all that begin a step.
    fn take(&mut self) -> (Vec<u64>, Vec<Request>) {
        let in_step = |seat: &Seat| matches!(&seat.stands, Stands::Asks(request) if !request.begins_step);
        let some_in_step = self.seats.values().any(in_step);
        let (mut ids, mut requests) = (Vec::new(), Vec::new());
        for (id, seat) in &mut self.seats {
            if some_in_step && !in_step(seat) {
                continue;
            }
            match std::mem::replace(&mut seat.stands, Stands::Served) {
                Stands::Asks(request) => {
                    ids.push(*id);
                    requests.push(request);
                }
                other => seat.stands = other,
            }
        }
        (ids, requests)
    }
}

impl Membership {
    /// The device itself.
    pub fn device(&self) -> &Arc<Gpu> {
        &self.core.gpu
    }

    pub fn core(&self) -> &Core {
        &self.core
    }

    /// Marks the next request as the beginning of a step.
    pub fn begin_step(&self) {
        self.begins_step.store(true, Ordering::Relaxed);
    }

    /// Tells the other members not to wait for this one.
    pub fn rest(&self) {
        self.stand(&mut lock(&self.core.board), Stands::Away);
        self.core.changed.notify_all();
    }

    /// Stores work until the next request.
    pub fn append(&self, work: impl IntoIterator<Item = Work>) {
        lock(&self.pending).extend(work);
    }

    /// Allocates a range of the arena, filled with zeros.
    ///
    /// # Errors
    /// [`GpuError::Limit`], [`GpuError::OutOfMemory`].
    pub fn take(&self, label: &'static str, bytes: u64) -> Result<Range<u64>, GpuError> {
        let (range, used) = lock(&self.core.arena).take(&self.core.gpu, label, bytes)?;
        if used {
            self.append([Work::Clear(range.clone())]);
        }
        Ok(range)
    }

    /// Requests the execution of all stored work, and waits for the bytes of these ranges.
    ///
    /// # Errors
    /// The fault of the device.
    pub fn ask(&self, read: Vec<Range<u64>>) -> Result<Vec<Vec<u8>>, GpuError> {
        let work = std::mem::take(&mut *lock(&self.pending));
        let begins_step = self.begins_step.swap(false, Ordering::Relaxed);
        let request = Request { work, read, begins_step };
        let mut board = lock(&self.core.board);
        self.stand(&mut board, Stands::Asks(request));
        self.core.changed.notify_all();
        loop {
            if let Some(seat) = board.seats.get_mut(&self.id)
                && matches!(seat.stands, Stands::Answered(_))
                && let Stands::Answered(answer) = std::mem::replace(&mut seat.stands, Stands::AtWork)
            {
                return answer;
            }
            if board.ended {
                return Err(GpuError::Lost { reason: "its ensemble has ended".into() });
            }
            board = self.answered.wait(board).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn stand(&self, board: &mut Board, stands: Stands) {
        board.changed = Instant::now();
        if let Some(seat) = board.seats.get_mut(&self.id) {
            seat.stands = stands;
        }
    }
}

impl Drop for Membership {
    fn drop(&mut self) {
        let pending = std::mem::take(&mut *lock(&self.pending));
        let mut arena = lock(&self.core.arena);
        for work in pending {
            if let Work::Leave(range) = work {
                arena.leave(range);
            }
        }
        drop(arena);
        let mut board = lock(&self.core.board);
        board.seats.remove(&self.id);
        board.changed = Instant::now();
        self.core.changed.notify_all();
    }
}
