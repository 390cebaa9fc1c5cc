//! Counts of messages, bytes and waiting time.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

static MESSAGES: AtomicU64 = AtomicU64::new(0);
static BYTES: AtomicU64 = AtomicU64::new(0);
static GATHERS: AtomicU64 = AtomicU64::new(0);
static GATHERED: AtomicU64 = AtomicU64::new(0);
static NANOSECONDS: AtomicU64 = AtomicU64::new(0);

/// What this process has exchanged with others since the program started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Point-to-point messages sent.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Collective operations.
    pub gathers: u64,
    /// Bytes sent in them.
    pub gathered: u64,
    /// Time spent in exchanges, most of it waiting.
    pub time: Duration,
}

impl Traffic {
    /// The counts so far.
    pub fn so_far() -> Traffic {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Traffic {
            messages: read(&MESSAGES),
            bytes: read(&BYTES),
            gathers: read(&GATHERS),
            gathered: read(&GATHERED),
            time: Duration::from_nanos(read(&NANOSECONDS)),
        }
    }

    pub(super) fn of_messages(messages: usize, bytes: usize, time: Duration) {
        MESSAGES.fetch_add(messages as u64, Ordering::Relaxed);
        BYTES.fetch_add(bytes as u64, Ordering::Relaxed);
        spent(time);
    }

    pub(super) fn of_gather(bytes: usize, time: Duration) {
        GATHERS.fetch_add(1, Ordering::Relaxed);
        GATHERED.fetch_add(bytes as u64, Ordering::Relaxed);
        spent(time);
    }
}

fn spent(time: Duration) {
    NANOSECONDS.fetch_add(time.as_nanos() as u64, Ordering::Relaxed);
}
