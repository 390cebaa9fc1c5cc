//! The shared data of a team's threads: vectors, sums of chunks, and a barrier.
//!
//! Values are exchanged as the bits of atomic integers. One thread writes each between two barriers, and others read it
//! after the second. Waiting threads spin, because a barrier comes every few microseconds, and after a while yield
//! their core to other work.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// The number of spins at a barrier before a waiting thread yields its core, some two microseconds. Two threads on one
/// core wait this long at each barrier: with 4,000 spins a hundred iterations took 38 ms instead of 3.
const SPINS: u32 = 100;

/// The largest number of sums in one reduction.
pub(super) const SUMS: usize = 6;

/// Values that several threads read and write.
#[derive(Default)]
pub(super) struct Numbers(Vec<AtomicU64>);

impl Numbers {
    fn zeros(n: usize) -> Self {
        Numbers((0..n).map(|_| AtomicU64::new(0)).collect())
    }

    #[inline]
    pub fn get(&self, place: usize) -> f64 {
        f64::from_bits(self.0[place].load(Ordering::Relaxed))
    }

    /// Reads the values from an offset on.
    #[inline]
    pub fn block<const D: usize>(&self, place: usize) -> [f64; D] {
        let numbers = &self.0[place..place + D];
        std::array::from_fn(|k| f64::from_bits(numbers[k].load(Ordering::Relaxed)))
    }

    /// Writes values from an offset on.
    #[inline]
    pub fn put(&self, place: usize, numbers: &[f64]) {
        for (to, number) in self.0[place..place + numbers.len()].iter().zip(numbers) {
            to.store(number.to_bits(), Ordering::Relaxed);
        }
    }
}

/// The values that members exchange: after a barrier each may read what the others wrote before it.
pub(super) struct Board {
    /// The entries of the vector that is multiplied that other members need, at the indices of the rows.
    pub x: Numbers,
    /// The same of `J^T x`, at the indices of the bodies.
    pub velocity: Numbers,
    /// Sums of the chunks, in two alternating buffers: a thread that writes one has passed a barrier since the others
    /// read it.
    pub sums: [Numbers; 2],
}

impl Board {
    /// For this many rows, velocity components and chunks.
    pub fn new(rows: usize, unknowns: usize, chunks: usize) -> Self {
        Board {
            x: Numbers::zeros(rows),
            velocity: Numbers::zeros(unknowns),
            sums: [Numbers::zeros(SUMS * chunks), Numbers::zeros(SUMS * chunks)],
        }
    }
}

/// How long the first member waits for the others: several times the time to wake a thread.
const PATIENCE: Duration = Duration::from_micros(200);

/// The states of a team's formation.
const FORMING: u32 = 0;
const COMPLETE: u32 = 1;
const GIVEN_UP: u32 = 2;

/// The shared state of a team.
pub(super) struct Shared {
    members: usize,
    present: AtomicUsize,
    formation: AtomicU32,
    arrived: AtomicUsize,
    round: AtomicUsize,
    /// Whether a member has panicked: without this flag the others would wait for it forever.
    broken: AtomicBool,
    /// The data that they exchange.
    pub board: Board,
}

impl Shared {
    /// For this many members, rows, velocity components and chunks.
    pub fn new(members: usize, rows: usize, unknowns: usize, chunks: usize) -> Self {
        Shared {
            members,
            present: AtomicUsize::new(0),
            formation: AtomicU32::new(FORMING),
            arrived: AtomicUsize::new(0),
            round: AtomicUsize::new(0),
            broken: AtomicBool::new(false),
            board: Board::new(rows, unknowns, chunks),
        }
    }

    /// Begins another round, whose members are still to come.
    pub fn form(&mut self) {
        (*self.present.get_mut(), *self.formation.get_mut()) = (0, FORMING);
    }

    /// The first member waits for the others. Returns whether all arrived in time: busy threads may take long, and an
    /// incomplete team would wait forever.
    pub fn gather(&self) -> bool {
        let begun = Instant::now();
        while self.present.load(Ordering::Acquire) + 1 < self.members {
            if begun.elapsed() > PATIENCE {
                self.formation.store(GIVEN_UP, Ordering::Release);
                return false;
            }
            std::hint::spin_loop();
        }
        self.formation.store(COMPLETE, Ordering::Release);
        true
    }

    /// Another member arrives. Returns whether the team is complete.
    pub fn join(&self) -> bool {
        self.present.fetch_add(1, Ordering::AcqRel);
        loop {
            match self.formation.load(Ordering::Acquire) {
                FORMING => std::thread::yield_now(),
                formation => return formation == COMPLETE,
            }
        }
    }

    /// Waits until all members have arrived. Everything that a member wrote before is visible to all after it.
    ///
    /// # Panics
    /// If another member has panicked.
    pub fn meet(&self) {
        let round = self.round.load(Ordering::Relaxed);
        if self.arrived.fetch_add(1, Ordering::AcqRel) + 1 == self.members {
            self.arrived.store(0, Ordering::Relaxed);
            self.round.store(round.wrapping_add(1), Ordering::Release);
            return;
        }
        let mut spins = 0;
        while self.round.load(Ordering::Acquire) == round {
            if spins < SPINS {
                spins += 1;
                std::hint::spin_loop();
                continue;
            }
            assert!(!self.broken.load(Ordering::Relaxed), "another thread of the solver has panicked");
            std::thread::yield_now();
        }
    }

    /// A guard that notifies the others if this member panics before it is dropped.
    pub fn guard(&self) -> Guard<'_> {
        Guard(self)
    }
}

/// See [`Shared::guard`].
pub(super) struct Guard<'a>(&'a Shared);

impl Drop for Guard<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.broken.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_members_read_what_all_wrote_before_they_met() {
        let shared = Shared::new(3, 3, 0, 0);
        let work = |member: usize| {
            for round in 0..200 {
                shared.board.x.put(member, &[f64::from(round)]);
                shared.meet();
                assert!((0..3).all(|other| shared.board.x.get(other) == f64::from(round)));
                shared.meet();
            }
        };
        std::thread::scope(|scope| {
            let work = &work;
            (0..3).for_each(|member| drop(scope.spawn(move || work(member))));
        });
    }

    #[test]
    fn a_team_that_does_not_come_together_is_given_up() {
        let shared = Shared::new(3, 0, 0, 0);
        let ended = std::thread::scope(|scope| {
            let came = scope.spawn(|| shared.join());
            (shared.gather(), came.join().ok())
        });
        assert_eq!(ended, (false, Some(false)));
        assert!(!shared.join(), "too late");
    }

    #[test]
    fn nobody_waits_for_a_member_that_panicked() {
        let shared = Shared::new(2, 0, 0, 0);
        let ended = std::thread::scope(|scope| {
            let waits = scope.spawn(|| shared.meet());
            let panics = scope.spawn(|| {
                let _guard = shared.guard();
                panic!("on purpose");
            });
            [waits.join().is_err(), panics.join().is_err()]
        });
        assert_eq!(ended, [true, true]);
    }
}
