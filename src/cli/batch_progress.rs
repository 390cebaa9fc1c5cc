//! The progress of a batch on standard error: one line per member that ends, and below it a bar on a terminal,
//! elsewhere a line every half minute.

use super::interrupt::Interrupt;
use super::output;
use indicatif::{ProgressBar, ProgressStyle};
use relcp::batch::{Ended, Member, MemberError, Watch};
use relcp::run::{Run, RunError, RunStatus};
use relcp::step::StepReport;
use std::collections::BTreeSet;
use std::error::Error;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Time between lines without a terminal: a log of one night should stay readable.
const LINE_EVERY: Duration = Duration::from_secs(30);
/// Time between updates of the bar.
const BAR_EVERY: Duration = Duration::from_millis(200);

/// Shows a batch's progress, and passes Ctrl-C on.
pub(super) struct BatchProgress {
    interrupt: Interrupt,
    quiet: bool,
    bar: OnceLock<ProgressBar>,
    members: AtomicUsize,
    ended: AtomicUsize,
    running: Mutex<BTreeSet<usize>>,
    steps: AtomicU64,
    taken: AtomicU64,
    shown: Mutex<Instant>,
}

impl BatchProgress {
    pub(super) fn new(quiet: bool) -> Self {
        BatchProgress {
            interrupt: Interrupt::listen(),
            quiet,
            bar: OnceLock::new(),
            members: AtomicUsize::new(0),
            ended: AtomicUsize::new(0),
            running: Mutex::default(),
            steps: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            shown: Mutex::new(Instant::now()),
        }
    }

    /// Removes the bar.
    pub(super) fn end(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }

    fn say(&self, text: &str) {
        match self.bar.get() {
            Some(bar) => bar.suspend(|| output::message(text)),
            None => output::message(text),
        }
    }

    fn text(&self) -> String {
        let (ended, members, running) =
            (self.ended.load(Relaxed), self.members.load(Relaxed), lock(&self.running).len());
        let (taken, steps) = (self.taken.load(Relaxed), self.steps.load(Relaxed));
        format!("{ended} of {members} members ended, {running} running, {taken} of {steps} steps")
    }

    fn show(&self) {
        let every = if self.bar.get().is_some() { BAR_EVERY } else { LINE_EVERY };
        // It suffices that another thread is showing it.
        let Ok(mut shown) = self.shown.try_lock() else { return };
        if self.quiet || shown.elapsed() < every {
            return;
        }
        *shown = Instant::now();
        match self.bar.get() {
            Some(bar) => {
                bar.set_position(self.taken.load(Relaxed));
                bar.set_message(self.text());
            }
            None => output::message(&self.text()),
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An error with its causes, on one line.
pub(super) fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}

/// A member in a message: the name of its folder and its parameters.
fn named(member: &Member) -> String {
    let (name, label) = (member.name(), member.label());
    if label.is_empty() { name } else { format!("{name} ({label})") }
}

impl Watch for BatchProgress {
    fn stop(&self) -> bool {
        self.interrupt.asked()
    }

    fn planned(&self, members: usize, steps: u64) {
        self.members.store(members, Relaxed);
        self.steps.store(steps, Relaxed);
        *lock(&self.shown) = Instant::now();
        if !self.quiet && members > 0 && std::io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("{bar:24} {percent:>3}%  {msg}");
            let bar = ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            let _ = self.bar.set(bar);
        }
    }

    fn begun(&self, member: &Member, run: &Run) {
        lock(&self.running).insert(member.index);
        self.taken.fetch_add(run.simulation().steps(), Relaxed);
        for note in run.notes() {
            self.say(&format!("{}: {note}", named(member)));
        }
    }

    fn stepped(&self, _: &Member, _: &StepReport) {
        self.taken.fetch_add(1, Relaxed);
        self.show();
    }

    fn ended(&self, member: &Member, ended: &Ended) {
        lock(&self.running).remove(&member.index);
        let how = match ended {
            Ended::Before(RunStatus::Stopped | RunStatus::Fault) => {
                return self
                    .say(&format!("{} stopped earlier; --retry continues from its last good state", named(member)));
            }
            Ended::Before(_) | Ended::NotBegun => return,
            Ended::Failed(MemberError::Run(RunError::Fault(fault))) if fault.is_of_scene() => {
                self.ended.fetch_add(1, Relaxed);
                return self.say(&format!("{} stopped: {fault}", named(member)));
            }
            Ended::Failed(error) => {
                self.ended.fetch_add(1, Relaxed);
                return self.say(&format!("{} failed: {}", named(member), chain(error)));
            }
            Ended::Now(RunStatus::Done) => "done",
            Ended::Now(RunStatus::OutOfTolerance) => "ended out of tolerance",
            Ended::Now(RunStatus::Interrupted) => "stopped, with a checkpoint",
            Ended::Now(_) => "stopped at a failed step",
        };
        let count = self.ended.fetch_add(1, Relaxed) + 1;
        if !self.quiet {
            self.say(&format!("{count} of {}: {} {how}", self.members.load(Relaxed), named(member)));
        }
    }
}
