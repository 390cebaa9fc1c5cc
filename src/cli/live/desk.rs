//! What the run and its page have in common. The run never waits for a connection; connections wait for the run.

use super::curves::Point;
use relcp::scene::Body;
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What a page may ask of the run.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Ask {
    Play,
    Pause,
    /// So many steps, then pause.
    Steps(u64),
    /// At most so many steps a second; none: as fast as they come.
    Speed(Option<f64>),
    /// Other values of keys from the present state on.
    Change(BTreeMap<String, Value>),
    /// Removes bodies and places others.
    Place {
        remove: Vec<u64>,
        add: Vec<Body>,
    },
    /// Drags a body, or goes on to.
    Pull(Pull),
    /// Lets a body go.
    LetGo(u64),
    /// Makes the present state the end.
    End,
}

/// A point of a body, in its axes, and where it is pulled to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pull {
    pub body: u64,
    pub point: [f64; 3],
    pub target: [f64; 3],
}

/// What a refusal says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Refusal {
    pub error: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

/// Something asked, and where its answer is expected.
pub(super) struct Asked {
    pub what: Ask,
    pub answer: SyncSender<Result<(), Refusal>>,
}

/// What the run does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Phase {
    Paused,
    Playing,
    /// Its last files are being written.
    Saving,
    Ended,
}

/// The status of the run, for its pages.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Status {
    /// Grows with each change of the others.
    pub version: u64,
    pub phase: Phase,
    pub name: String,
    pub folder: String,
    /// The end of its time.
    pub end: f64,
    /// Changes of its scene so far, made and to come.
    pub changes: usize,
    pub steps_a_second: Option<f64>,
    /// What is to be said at the end.
    pub message: Option<String>,
}

/// A state as the page reads it, with the figures up to it.
pub(super) struct Frame {
    pub step: u64,
    pub bytes: Vec<u8>,
    pub points: Vec<Point>,
}

/// All that is shared.
pub(super) struct Told {
    pub status: Status,
    pub frame: Option<Arc<Frame>>,
    /// How often a user has removed or placed bodies: a state that was taken before the last time is old.
    pub edits: u64,
    /// The keys that may change, with their values, as JSON.
    pub keys: Arc<[u8]>,
    asked: VecDeque<Asked>,
    /// The least step of a frame that someone waits for.
    pub wanted: Option<u64>,
    /// The step of the present state, while the run does not play.
    pub rests_at: u64,
    /// When a page has last asked for states.
    pub watched: Option<Instant>,
    /// Whether a page knows that the run has ended.
    pub end_is_known: bool,
}

/// The place where both meet.
pub(super) struct Desk {
    told: Mutex<Told>,
    bell: Condvar,
    /// Whether there is anything for the run to look at.
    calls: AtomicBool,
}

impl Desk {
    pub fn new(status: Status) -> Self {
        let told = Told {
            status,
            frame: None,
            edits: 0,
            keys: Arc::from(&b"[]"[..]),
            asked: VecDeque::new(),
            wanted: None,
            rests_at: 0,
            watched: None,
            end_is_known: false,
        };
        Desk { told: Mutex::new(told), bell: Condvar::new(), calls: AtomicBool::new(false) }
    }

    /// What is shared. A thread that panicked has ended the program, so the lock is always whole.
    pub fn told(&self) -> MutexGuard<'_, Told> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the run should look, which costs it nothing where it need not.
    pub fn calls(&self) -> bool {
        self.calls.load(Ordering::Relaxed)
    }

    /// The same, and the run looks now.
    pub fn heard(&self) -> bool {
        self.calls() && self.calls.swap(false, Ordering::Relaxed)
    }

    /// Wakes all that wait.
    pub fn ring(&self) {
        self.bell.notify_all();
    }

    /// Waits for a ring, at most so long.
    pub fn wait<'a>(&self, told: MutexGuard<'a, Told>, most: Duration) -> MutexGuard<'a, Told> {
        self.bell.wait_timeout(told, most).unwrap_or_else(PoisonError::into_inner).0
    }

    /// Has the run look. The lock is held meanwhile, so that a run that is about to wait hears it.
    pub fn call(&self, _told: &MutexGuard<'_, Told>) {
        self.calls.store(true, Ordering::Relaxed);
        self.ring();
    }

    /// Puts a question to the run, unless it no longer answers.
    pub fn ask(&self, asked: Asked) -> Result<(), Refusal> {
        let mut told = self.told();
        if matches!(told.status.phase, Phase::Saving | Phase::Ended) {
            return Err(Refusal::new("the run has ended"));
        }
        told.asked.push_back(asked);
        self.call(&told);
        Ok(())
    }

    /// The next thing asked.
    pub fn next(&self) -> Option<Asked> {
        self.told().asked.pop_front()
    }

    /// Tells something else of the run from now on.
    pub fn tell(&self, change: impl FnOnce(&mut Status)) {
        let mut told = self.told();
        let before = told.status.clone();
        change(&mut told.status);
        if told.status != before {
            told.status.version += 1;
        }
        drop(told);
        self.ring();
    }

    /// Refuses all that is still asked.
    pub fn refuse_all(&self) {
        let asked = std::mem::take(&mut self.told().asked);
        for asked in asked {
            // Who has gone needs no answer.
            let _ = asked.answer.try_send(Err(Refusal::new("the run has ended")));
        }
    }
}

impl Told {
    /// The step of the newest frame.
    pub fn newest(&self) -> Option<u64> {
        self.frame.as_ref().map(|frame| frame.step)
    }

    /// The frame for a page that has that of a step, or none yet, if there is one; else it is wanted from now on. The
    /// newest one `before` the page asked may be old.
    pub fn frame_after(&mut self, has: Option<u64>, before: Option<u64>) -> Option<Arc<Frame>> {
        let from = match (has, self.status.phase) {
            (Some(step), _) => step.saturating_add(1),
            (None, Phase::Playing) => before.map_or(0, |step| step + 1),
            (None, _) => self.rests_at,
        };
        let frame = self.frame.clone().filter(|frame| frame.step >= from);
        if frame.is_none() {
            self.wanted = Some(self.wanted.map_or(from, |wanted| wanted.min(from)));
        }
        frame
    }
}

impl Refusal {
    pub fn new(error: impl Into<String>) -> Self {
        Refusal { error: error.into(), help: None }
    }
}
