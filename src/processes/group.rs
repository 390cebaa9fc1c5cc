//! The processes of a run and their exchanges.

use super::Traffic;
use mpi::Count;
use mpi::datatype::PartitionMut;
use mpi::request::{Request, scope};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Destination, Equivalence, Root, Source};
use std::time::{Duration, Instant};

/// Most numbers in one gather: MPI counts them in 32 bits. Longer gathers run in pieces.
const MOST_AT_ONCE: usize = 1 << 28;

/// The processes that run one simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Processes {
    rank: usize,
    size: usize,
}

/// Numbers for, or from, one other process.
pub(crate) type Parcel<T = f64> = (usize, Vec<T>);

impl Processes {
    /// All processes of the MPI launch.
    pub(super) fn all() -> Self {
        let world = SimpleCommunicator::world();
        Processes { rank: world.rank() as usize, size: world.size() as usize }
    }

    /// The rank of this process, from 0.
    pub fn rank(self) -> usize {
        self.rank
    }

    /// The number of processes.
    pub fn size(self) -> usize {
        self.size
    }

    /// Concatenates the lists of all processes by rank, on every process.
    pub fn all_gather(self, own: &[u64]) -> Vec<u64> {
        let mut counts = vec![0u64; self.size];
        self.gather_into(&[own.len() as u64], &vec![1; self.size], &mut counts);
        let counts: Vec<usize> = counts.into_iter().map(|count| count as usize).collect();
        let mut all = vec![0u64; counts.iter().sum()];
        self.gather_into(own, &counts, &mut all);
        all
    }

    /// [`Processes::all_gather`] with known lengths.
    fn gather_into<T: Equivalence + Copy>(self, own: &[T], counts: &[usize], all: &mut [T]) {
        let begun = Instant::now();
        if all.len() <= MOST_AT_ONCE {
            gather_at_once(own, counts, all);
        } else {
            self.gather_in_pieces(own, counts, all);
        }
        Traffic::of_gather(size_of_val(own) * (self.size - 1), begun.elapsed());
    }

    fn gather_in_pieces<T: Equivalence + Copy>(self, own: &[T], counts: &[usize], all: &mut [T]) {
        let most = (MOST_AT_ONCE / self.size).max(1);
        let longest = counts.iter().copied().max().unwrap_or(0);
        let Some(first) = all.first().copied() else { return };
        let mut piece = Vec::new();
        for begin in (0..longest).step_by(most) {
            let within = |count: usize| begin.min(count)..(begin + most).min(count);
            let lengths: Vec<usize> = counts.iter().map(|count| within(*count).len()).collect();
            piece.resize(lengths.iter().sum(), first);
            gather_at_once(&own[within(own.len())], &lengths, &mut piece);
            let (mut from, mut to) = (0, 0);
            for (count, length) in counts.iter().zip(&lengths) {
                all[to + begin.min(*count)..][..*length].copy_from_slice(&piece[from..from + length]);
                from += length;
                to += count;
            }
        }
    }

    /// [`Processes::all_gather`] of lists of equal length.
    pub(crate) fn all_gather_even<T: Equivalence>(self, own: &[T], all: &mut [T]) {
        let begun = Instant::now();
        SimpleCommunicator::world().all_gather_into(own, all);
        Traffic::of_gather(size_of_val(own) * (self.size - 1), begun.elapsed());
    }

    /// [`Processes::all_gather`] to rank 0 only; the others get nothing.
    pub(crate) fn gather_to_root(self, own: &[u64]) -> Vec<u64> {
        let lengths: Vec<usize> = self.gather_lengths(own.len());
        let into = |(from, length): (usize, &usize)| (self.rank == 0 && from > 0).then(|| (from, vec![0; *length]));
        let mut parcels: Vec<Parcel<u64>> = lengths.iter().enumerate().filter_map(into).collect();
        let out = if self.rank == 0 { Vec::new() } else { vec![(0, own.to_vec())] };
        self.exchange(&out, &mut parcels, || {});
        let own = if self.rank == 0 { own } else { &[] };
        own.iter().copied().chain(parcels.into_iter().flat_map(|(_, numbers)| numbers)).collect()
    }

    fn gather_lengths(self, own: usize) -> Vec<usize> {
        let mut all = vec![0_u64; self.size];
        self.all_gather_even(&[own as u64], &mut all);
        all.into_iter().map(|length| length as usize).collect()
    }

    /// Sends list `i` to rank `i`, and returns the lists received, by rank.
    pub(crate) fn all_to_all(self, mut lists: Vec<Vec<u64>>) -> Vec<Vec<u64>> {
        let lengths: Vec<u64> = lists.iter().map(|list| list.len() as u64).collect();
        let mut coming = vec![0_u64; self.size];
        SimpleCommunicator::world().all_to_all_into(&lengths, &mut coming);
        let mut all = vec![Vec::new(); self.size];
        all[self.rank] = std::mem::take(&mut lists[self.rank]);
        let out: Vec<Parcel<u64>> = lists.into_iter().enumerate().filter(|(_, list)| !list.is_empty()).collect();
        let room = |(from, length): (usize, u64)| (from, vec![0; length as usize]);
        let others = |(from, length): &(usize, u64)| *from != self.rank && *length > 0;
        let mut into: Vec<Parcel<u64>> = coming.into_iter().enumerate().filter(others).map(room).collect();
        self.exchange(&out, &mut into, || {});
        into.into_iter().for_each(|(from, list)| all[from] = list);
        all
    }

    /// Sends the parcels of `out` and receives into those of `into`, whose lengths match what the other side sends.
    /// `meanwhile` runs while the messages are in transit.
    pub(crate) fn exchange<T: Equivalence>(self, out: &[Parcel<T>], into: &mut [Parcel<T>], meanwhile: impl FnOnce()) {
        let begun = Instant::now();
        let world = SimpleCommunicator::world();
        let mut worked = Duration::ZERO;
        scope(|scope| {
            let mut pending: Vec<Request<'_, [T], _>> = Vec::with_capacity(into.len() + out.len());
            for (from, numbers) in into.iter_mut() {
                let from = world.process_at_rank(*from as i32);
                pending.push(from.immediate_receive_into(scope, numbers.as_mut_slice()));
            }
            for (to, numbers) in out {
                pending.push(world.process_at_rank(*to as i32).immediate_send(scope, numbers.as_slice()));
            }
            let sent = Instant::now();
            meanwhile();
            worked = sent.elapsed();
            for request in pending {
                request.wait();
            }
        });
        let bytes = out.iter().map(|(_, numbers)| size_of_val(numbers.as_slice())).sum();
        Traffic::of_messages(out.len(), bytes, begun.elapsed() - worked);
    }

    /// Says something to all others, which [Processes::receive`] it.
    pub fn broadcast(self, message: &[u8]) {
        let begun = Instant::now();
        let mut length = message.len() as u64;
        self.take_from_first(std::slice::from_mut(&mut length));
        let mut own = message.to_vec();
        own.chunks_mut(MOST_AT_ONCE).for_each(|piece| self.take_from_first(piece));
        Traffic::of_gather(own.len() * (self.size - 1), begun.elapsed());
    }

    /// Waits for a broadcast of rank 0.
    pub fn receive(self) -> Vec<u8> {
        let mut length = 0u64;
        self.take_from_first(std::slice::from_mut(&mut length));
        let mut message = vec![0u8; length as usize];
        message.chunks_mut(MOST_AT_ONCE).for_each(|piece| self.take_from_first(piece));
        message
    }

    fn take_from_first<T: Equivalence>(self, numbers: &mut [T]) {
        SimpleCommunicator::world().process_at_rank(0).broadcast_into(numbers);
    }

    /// Ends all processes at once: the others would wait for one that fails.
    pub fn abort(self, status: u8) -> ! {
        SimpleCommunicator::world().abort(i32::from(status))
    }
}

fn gather_at_once<T: Equivalence>(own: &[T], counts: &[usize], all: &mut [T]) {
    let counts: Vec<Count> = counts.iter().map(|count| *count as Count).collect();
    let begins = counts.iter().scan(0, |next, count| Some(std::mem::replace(next, *next + count)));
    let begins: Vec<Count> = begins.collect();
    SimpleCommunicator::world().all_gather_varcount_into(own, &mut PartitionMut::new(all, counts, begins));
}
