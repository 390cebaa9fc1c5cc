//! Independent runs, each on its own thread.

use crate::StudyError;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Returns the result of `work` for each number below `count`, in order, computed by several threads. The loops
/// of each run have one thread.
///
/// # Errors
/// [`StudyError::Threads`].
pub(super) fn spread<T: Send>(
    count: usize,
    threads: usize,
    work: &(dyn Fn(usize) -> T + Sync),
) -> Result<Vec<T>, StudyError> {
    let next = AtomicUsize::new(0);
    let ended: Mutex<Vec<(usize, T)>> = Mutex::default();
    let until_none_is_left = || {
        loop {
            let place = next.fetch_add(1, Ordering::Relaxed);
            if place >= count {
                break;
            }
            let made = work(place);
            ended.lock().unwrap_or_else(PoisonError::into_inner).push((place, made));
        }
    };
    let jobs = threads.clamp(1, count.max(1));
    let pools = (0..jobs).map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build());
    let pools = pools.collect::<Result<Vec<_>, _>>().map_err(|e| StudyError::Threads(e.to_string()))?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| pool.install(until_none_is_left));
        }
    });
    let mut made = ended.into_inner().unwrap_or_else(PoisonError::into_inner);
    made.sort_by_key(|(place, _)| *place);
    Ok(made.into_iter().map(|(_, made)| made).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_worked_on_once_and_comes_in_its_place() {
        for threads in [0, 1, 3, 50] {
            let squares = spread(20, threads, &|number| number * number).unwrap();
            assert_eq!(squares, (0..20).map(|number| number * number).collect::<Vec<usize>>());
        }
        assert_eq!(spread(0, 2, &|number| number).unwrap(), Vec::<usize>::new());
    }
}
