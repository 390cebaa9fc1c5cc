//! The run's side: between two steps it does what the page asks, and gives it states.

use super::curves::Curves;
use super::desk::{Ask, Asked, Desk, Phase, Pull, Refusal, Status};
use super::frames::{Frames, Look};
use crate::cli::exit::CliError;
use crate::cli::output;
use relcp::Error;
use relcp::run::Run;
use relcp::step::StepReport;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A run that waits looks so often for a signal, and for a state that has to wait for its time.
const LOOK_EVERY: Duration = Duration::from_millis(100);
const LOOK_FOR_STATE: Duration = Duration::from_millis(10);
/// A page that has asked for nothing for so long is closed.
const CLOSED_AFTER: Duration = Duration::from_secs(10);
/// A page that drags a body says so every second; a hand that is silent for so long has let go.
const HAND_GONE_AFTER: Duration = Duration::from_secs(5);
/// The longest time that the program waits for a page to learn of the run's end: a browser without a GPU on a busy
/// machine took more than 3 s to draw a state.
const LAST_WORDS: Duration = Duration::from_secs(10);

/// A run with its page.
pub(in crate::cli) struct Driver {
    desk: Arc<Desk>,
    frames: Frames,
    curves: Curves,
    /// Steps to take before it pauses; none while it plays.
    steps_left: Option<u64>,
    steps_a_second: Option<f64>,
    next_step: Instant,
    changes_made: usize,
    waited: bool,
    /// When to look again for a page that waits.
    look: Look,
    /// The body that is dragged, and when its page has last said so.
    hand: Option<(u64, Instant)>,
}

impl Driver {
    /// A run that pauses at first, and the desk where its page meets it.
    pub(super) fn start(run: &Run) -> Result<(Driver, Arc<Desk>), CliError> {
        let simulation = run.simulation();
        let desk = Arc::new(Desk::new(Status {
            version: 1,
            phase: Phase::Paused,
            name: simulation.scene().name.clone(),
            folder: run.folder().path().display().to_string(),
            end: simulation.scene().time.end,
            changes: simulation.whole_scene().changes.len(),
            steps_a_second: None,
            message: None,
        }));
        let driver = Driver {
            frames: Frames::start(simulation, &desk)?,
            desk: desk.clone(),
            curves: Curves::default(),
            steps_left: Some(0),
            steps_a_second: None,
            next_step: Instant::now(),
            changes_made: simulation.changes_made(),
            waited: false,
            look: Look::Called,
            hand: None,
        };
        driver.rest(run, Phase::Paused);
        driver.tell_keys(run)?;
        Ok((driver, desk))
    }

    /// Attends to the page until the next step is due. Whether it is: else the run has ended, or `stop` says so.
    pub fn attend(&mut self, run: &mut Run, stop: &dyn Fn() -> bool) -> Result<bool, CliError> {
        self.waited = false;
        loop {
            if self.desk.heard() || self.look != Look::Called {
                self.answer_all(run)?;
            }
            if let Some((body, _)) = self.hand.filter(|(_, last)| last.elapsed() >= HAND_GONE_AFTER) {
                // Where the scene refuses it, the body stays held.
                let _ = self.let_go(run, body)?;
            }
            if run.done() || stop() {
                return Ok(false);
            }
            let plays = self.steps_left != Some(0);
            let now = Instant::now();
            if plays && (self.steps_a_second.is_none() || now >= self.next_step) {
                self.next_step = now.max(self.next_step) + self.pause_between();
                return Ok(true);
            }
            self.waited = true;
            let most = if plays { self.next_step - now } else { LOOK_EVERY };
            let look = if self.look == Look::Soon { LOOK_FOR_STATE } else { LOOK_EVERY };
            let told = self.desk.told();
            // What came since the start of this turn has set this.
            if !self.desk.calls() {
                drop(self.desk.wait(told, most.min(look)));
            }
        }
    }

    /// Whether the run has waited before the present step.
    pub fn waited(&self) -> bool {
        self.waited
    }

    /// Takes note of a step.
    pub fn after(&mut self, run: &Run, report: &StepReport) -> Result<(), CliError> {
        self.curves.push(report);
        if self.changes_made != run.simulation().changes_made() {
            self.changes_made = run.simulation().changes_made();
            self.tell_keys(run)?;
        }
        if let Some(left) = &mut self.steps_left {
            *left -= 1;
            if *left == 0 {
                self.rest(run, Phase::Paused);
            }
        }
        Ok(())
    }

    /// Tells the page that the run has ended, and gives it the last state.
    pub fn ends(&mut self, run: &Run) {
        self.rest(run, Phase::Saving);
        self.desk.refuse_all();
        let begun = Instant::now();
        if self.is_watched() {
            let mut told = self.desk.told();
            if told.newest() != Some(told.rests_at) {
                told.wanted = Some(told.rests_at);
            }
        }
        // A device that was lost has no last state.
        let mut offer = || self.frames.offer(run.simulation(), &self.curves, &self.desk, true);
        while matches!(offer(), Ok(Look::Soon)) && begun.elapsed() < LAST_WORDS {
            drop(self.desk.wait(self.desk.told(), LOOK_FOR_STATE));
        }
    }

    fn is_watched(&self) -> bool {
        self.desk.told().watched.is_some_and(|last| last.elapsed() < CLOSED_AFTER)
    }

    /// Tells a page that watches why the run could not go on; the last state is offered where it can be.
    pub fn failed(mut self, run: &Run, why: &str, stop: &dyn Fn() -> bool) {
        self.ends(run);
        self.ended(format!("stopped: {why}"), stop);
    }

    /// Says how the run has ended, and waits a moment for a page that watches to hear it.
    pub fn ended(self, message: String, stop: &dyn Fn() -> bool) {
        self.desk.tell(|status| (status.phase, status.message) = (Phase::Ended, Some(message)));
        let begun = Instant::now();
        let watched = self.is_watched();
        let mut told = self.desk.told();
        while watched && !told.end_is_known && begun.elapsed() < LAST_WORDS && !stop() {
            told = self.desk.wait(told, LOOK_EVERY);
        }
    }

    fn pause_between(&self) -> Duration {
        let seconds = self.steps_a_second.map_or(0.0, |most| 1.0 / most);
        Duration::try_from_secs_f64(seconds).unwrap_or(Duration::ZERO)
    }

    fn answer_all(&mut self, run: &mut Run) -> Result<(), CliError> {
        while let Some(Asked { what, answer }) = self.desk.next() {
            let answered = self.answer(run, what)?;
            // Who has gone needs no answer.
            let _ = answer.try_send(answered);
        }
        let rests = self.steps_left == Some(0);
        self.look = self.frames.offer(run.simulation(), &self.curves, &self.desk, rests)?;
        Ok(())
    }

    /// Does what is asked. The outer error ends the run.
    fn answer(&mut self, run: &mut Run, what: Ask) -> Result<Result<(), Refusal>, CliError> {
        if run.done() {
            return Ok(Err(Refusal::new("the run has ended")));
        }
        match what {
            Ask::Play => self.play(None),
            Ask::Pause => {
                self.steps_left = Some(0);
                self.rest(run, Phase::Paused);
            }
            Ask::Steps(count) => self.play(Some(count)),
            Ask::Speed(most) => {
                (self.steps_a_second, self.next_step) = (most, Instant::now());
                self.desk.tell(|status| status.steps_a_second = most);
            }
            Ask::End => {
                if let Some((body, _)) = self.hand {
                    let _ = self.let_go(run, body)?;
                }
                run.end_here()?;
                let end = run.simulation().scene().time.end;
                self.desk.tell(|status| status.end = end);
            }
            Ask::Change(set) => {
                let changed = run.change(set);
                return self.changed(run, changed);
            }
            Ask::Place { remove, add } => {
                let changed = run.place(remove, add);
                if changed.is_ok() {
                    self.frames.again(&self.desk);
                }
                return self.changed(run, changed);
            }
            Ask::Pull(Pull { body, point, target }) => {
                // Another body was held by a page that has gone.
                if let Some((other, _)) = self.hand.filter(|(other, _)| *other != body) {
                    let _ = self.let_go(run, other)?;
                }
                let pulled = run.pull(body, point, target);
                self.hand = pulled.is_ok().then(|| (body, Instant::now()));
                return self.changed(run, pulled);
            }
            Ask::LetGo(body) => return self.let_go(run, body),
        }
        Ok(Ok(()))
    }

    fn let_go(&mut self, run: &mut Run, body: u64) -> Result<Result<(), Refusal>, CliError> {
        self.hand = None;
        let changed = run.let_go(body);
        self.changed(run, changed)
    }

    /// Tells what a change of the scene has changed.
    fn changed(&self, run: &Run, changed: Result<(), Error>) -> Result<Result<(), Refusal>, CliError> {
        if let Err(refused) = changed {
            return refusal(refused).map(Err);
        }
        let changes = run.simulation().whole_scene().changes.len();
        if self.desk.told().status.changes != changes {
            self.tell_keys(run)?;
            self.desk.tell(|status| status.changes = changes);
        }
        Ok(Ok(()))
    }

    fn play(&mut self, steps: Option<u64>) {
        (self.steps_left, self.next_step) = (steps, Instant::now());
        self.desk.tell(|status| status.phase = Phase::Playing);
    }

    fn rest(&self, run: &Run, phase: Phase) {
        self.desk.told().rests_at = run.simulation().steps();
        self.desk.tell(|status| status.phase = phase);
    }

    /// Tells the keys that may change, with the values of the next step.
    fn tell_keys(&self, run: &Run) -> Result<(), CliError> {
        let keys = run.simulation().coming_scene().adjustable();
        let keys = serde_json::to_vec(&keys).map_err(|why| CliError::Output(why.into()))?;
        self.desk.told().keys = Arc::from(keys);
        self.desk.tell(|status| status.version += 1);
        Ok(())
    }
}

/// The answer to a change that was refused. The outer error is one of a file, which ends the run.
fn refusal(error: Error) -> Result<Refusal, CliError> {
    match error {
        Error::Scene(fault) => Ok(Refusal { error: fault.to_string(), help: fault.help_text().map(str::to_owned) }),
        Error::Change(fault) => Ok(Refusal::new(fault.to_string())),
        Error::Run(fault) => Err(fault.into()),
        Error::Record(fault) => Err(fault.into()),
        other => {
            output::message(&format!("a change was refused: {other}"));
            Ok(Refusal::new(other.to_string()))
        }
    }
}
