//! The loop over mutants of one reader, and the damage that any bytes take.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

/// Mutants of all readers, where the environment does not say.
const MUTANTS: u64 = 10_000;
/// Readers that share them.
const READERS: u64 = 4;
/// Longest mutant, in bytes: spans that are doubled again and again must not make the test itself slow.
const LONGEST: usize = 1 << 18;

/// What became of a mutant.
#[derive(Clone, Copy, PartialEq)]
pub enum Fate {
    /// It was refused by a typed error.
    Refused,
    /// It was read.
    Read,
    /// It was read, and what it says was made.
    Made,
}

/// How many mutants had which fate.
#[derive(Debug, Default)]
pub struct Tally {
    pub refused: u64,
    pub read: u64,
    pub made: u64,
}

/// Makes a reader's share of the mutants `of` some inputs by `make`, and gives each to `read`. Panics with the mutants
/// that `read` panicked at.
pub fn each<T>(
    (reader, name): (u64, &str),
    of: &[T],
    make: impl Fn(&mut ChaCha8Rng, &T) -> Vec<u8>,
    read: impl Fn(&[u8]) -> Fate,
) -> Tally {
    let all = std::env::var("RELCP_MUTATIONS").map_or(MUTANTS, |count| count.parse().unwrap());
    let (begun, mut slowest) = (Instant::now(), (Duration::ZERO, Vec::new()));
    let (mut tally, mut panicked) = (Tally::default(), Vec::new());
    for mutant in 0..all / READERS {
        let mut random = ChaCha8Rng::seed_from_u64(reader);
        random.set_stream(mutant);
        let input = &of[random.random_range(0..of.len())];
        let bytes = make(&mut random, input);
        let started = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| read(&bytes))) {
            Ok(Fate::Refused) => tally.refused += 1,
            Ok(Fate::Read) => tally.read += 1,
            Ok(Fate::Made) => tally.made += 1,
            Err(_) => panicked.push((mutant, shown(&bytes))),
        }
        slowest = slowest.max((started.elapsed(), bytes));
    }
    eprintln!(
        "{name}: {tally:?} in {:.1?}, the slowest {:.1?}: {:.300?}",
        begun.elapsed(),
        slowest.0,
        shown(&slowest.1)
    );
    assert!(
        panicked.is_empty(),
        "{} {name} panicked, of them {:#?}",
        panicked.len(),
        &panicked[..panicked.len().min(5)]
    );
    tally
}

/// The start of a mutant, for people.
fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).chars().take(3_000).collect()
}

/// One of several.
pub fn pick<'a, T: ?Sized>(random: &mut ChaCha8Rng, of: &[&'a T]) -> &'a T {
    of[random.random_range(0..of.len())]
}

/// A span of something of this length, mostly short.
pub fn span(random: &mut ChaCha8Rng, length: usize) -> std::ops::Range<usize> {
    let start = random.random_range(0..=length);
    let most = if random.random_bool(0.8) { 16 } else { length };
    start..(start + random.random_range(0..=most)).min(length)
}

/// Damage that knows nothing of what the bytes say.
pub fn damage(random: &mut ChaCha8Rng, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        return;
    }
    let at = random.random_range(0..bytes.len());
    match random.random_range(0..8) {
        0 | 1 => bytes[at] ^= 1 << random.random_range(0..8),
        2 => bytes[at] = random.random(),
        3 => bytes.truncate(at),
        4 => drop(bytes.drain(span(random, bytes.len()))),
        5 => {
            let copied = bytes[span(random, bytes.len())].to_vec();
            bytes.splice(at..at, copied);
        }
        6 => {
            let copied = bytes[span(random, bytes.len())].to_vec();
            let end = (at + copied.len()).min(bytes.len());
            bytes.splice(at..end, copied);
        }
        _ => {
            // A count or a number of a binary file, of one to eight bytes.
            let number =
                [0, 1, -1, i64::MAX, i64::MIN, 1 << 40, 0x7fff_ffff, 0x7ff8_0000_0000_0000][random.random_range(0..8)];
            let width = [1, 2, 4, 8][random.random_range(0..4)].min(bytes.len() - at);
            bytes[at..at + width].copy_from_slice(&number.to_le_bytes()[..width]);
        }
    }
    bytes.truncate(LONGEST);
}
