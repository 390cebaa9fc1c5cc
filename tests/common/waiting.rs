//! Waiting for what a process does.

use std::process::Child;
use std::time::Duration;

/// Looks, every ten milliseconds, whether something has come. Not for ever, so that a test of what never comes ends.
pub fn comes(mut condition: impl FnMut() -> bool) -> bool {
    (0..60_000).any(|_| {
        let has_come = condition();
        if !has_come {
            std::thread::sleep(Duration::from_millis(10));
        }
        has_come
    })
}

/// Threads of a process, when they have been the same for a while.
pub fn settled(child: &Child, at_least: usize) -> usize {
    let count = || std::fs::read_dir(format!("/proc/{}/task", child.id())).map_or(0, Iterator::count);
    let (mut last, mut same) = (0, 0);
    let settled = comes(|| {
        let now = count();
        (last, same) = (now, if now == last { same + 1 } else { 0 });
        last >= at_least && same >= 30
    });
    assert!(settled, "{last} threads, expected {at_least} or more");
    last
}
