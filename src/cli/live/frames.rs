//! States for the page. The run copies a state and goes on; another thread packs it. Both together take at most a small
//! part of the run's time, however many pages watch, and nothing without any.

use super::curves::Curves;
use super::desk::{Desk, Frame};
use crate::cli::exit::CliError;
use relcp::run::RunError;
use relcp::simulation::Simulation;
use relcp::view::{Live, Taken};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The part of the time of a run that plays that goes into states for its page. A watched run may be slowed by 5 %;
/// the rest is for the browser's share of the memory.
const PART: f64 = 0.03;
/// The least time between two states: no screen shows more.
const LEAST: Duration = Duration::from_millis(33);

/// A state that is to be packed, and the figures up to it.
struct Job {
    taken: Taken,
    curves: Curves,
    begun: Instant,
    copied: Duration,
    /// The edits before it.
    edits: u64,
}

/// When the next state may be taken, and whether one is being packed.
#[derive(Default)]
struct Pace {
    next: Option<Instant>,
    packing: bool,
}

/// When the run has to look again for a page that waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// When it is called.
    Called,
    /// After the next step.
    NextStep,
    /// Soon: the present state is wanted, but it is not time yet.
    Soon,
}

/// The run's side.
pub(super) struct Frames {
    live: Live,
    jobs: SyncSender<Job>,
    pace: Arc<Mutex<Pace>>,
    /// The step of the last state that was taken.
    last: Option<u64>,
}

impl Frames {
    pub fn start(simulation: &Simulation, desk: &Arc<Desk>) -> Result<Self, CliError> {
        let live = Live::of(simulation).map_err(RunError::from)?;
        let (jobs, waiting) = sync_channel(1);
        let pace = Arc::<Mutex<Pace>>::default();
        let (desk, paced) = (desk.clone(), pace.clone());
        std::thread::Builder::new()
            .name("frames".into())
            .spawn(move || pack(&waiting, &desk, &paced))
            .map_err(|why| CliError::Usage(format!("cannot start a thread for the page: {why}")))?;
        Ok(Frames { live, jobs, pace, last: None })
    }

    /// Takes the present state again, since its bodies are others now.
    pub fn again(&mut self, desk: &Desk) {
        self.last = None;
        let mut told = desk.told();
        (told.frame, told.wanted) = (None, Some(told.rests_at));
        told.edits += 1;
    }

    /// Takes the present state if a page waits for it and it is time; of a run that rests, it always is.
    pub fn offer(
        &mut self,
        simulation: &Simulation,
        curves: &Curves,
        desk: &Desk,
        rests: bool,
    ) -> Result<Look, RunError> {
        let step = simulation.steps();
        let (wanted, edits) = {
            let told = desk.told();
            (told.wanted, told.edits)
        };
        let Some(from) = wanted else { return Ok(Look::Called) };
        if step < from || self.last == Some(step) {
            return Ok(Look::NextStep);
        }
        {
            let mut pace = self.pace.lock().unwrap_or_else(PoisonError::into_inner);
            if pace.packing || (!rests && pace.next.is_some_and(|next| Instant::now() < next)) {
                return Ok(Look::Soon);
            }
            pace.packing = true;
        }
        let begun = Instant::now();
        let taken = self.live.take(simulation)?;
        self.last = Some(step);
        let job = Job { taken, curves: curves.clone(), begun, copied: begun.elapsed(), edits };
        // The packing thread has nothing else to do, so that there is room.
        let _ = self.jobs.try_send(job);
        Ok(Look::NextStep)
    }
}

/// Packs states until the run ends, on one core.
fn pack(jobs: &Receiver<Job>, desk: &Desk, pace: &Mutex<Pace>) {
    // Its parallel loops must not take threads of the run's steps.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    while let Ok(Job { taken, curves, begun, copied, edits }) = jobs.recv() {
        let packing = Instant::now();
        let step = taken.step();
        let bytes = match &pool {
            Ok(pool) => pool.install(|| taken.pack()),
            Err(_) => taken.pack(),
        };
        let cost = copied + packing.elapsed();
        {
            let mut pace = pace.lock().unwrap_or_else(PoisonError::into_inner);
            pace.packing = false;
            pace.next = Some(begun + LEAST.max(cost.div_f64(PART)));
        }
        let mut told = desk.told();
        if let Some(bytes) = bytes.ok().filter(|_| told.edits == edits) {
            told.frame = Some(Arc::new(Frame { step, bytes, points: curves.points().to_vec() }));
            told.wanted = None;
        }
        desk.call(&told);
    }
}
