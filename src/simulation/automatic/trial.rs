//! A trial: some steps that the machine not in use takes, and what their times say.

use super::{Machine, Settings};

/// What a trial says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// It pays: this many seconds a step.
    Pays(f64),
    /// It does not: this many seconds a step, as far as was measured.
    DoesNotPay(f64),
}

/// A trial under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    /// The machine that is tried.
    pub(super) of: Machine,
    /// When it was begun.
    pub(super) begun: f64,
    /// Seconds that the other machine takes for a step.
    pub(super) rival: f64,
    /// Seconds that its steps may take in all beyond those of the rival.
    allowed: f64,
    pub(super) steps: u32,
    in_steps: f64,
    timed: f64,
}

impl Trial {
    pub(super) fn new(of: Machine, begun: f64, rival: f64, allowed: f64) -> Self {
        Trial { of, begun, rival, allowed, steps: 0, in_steps: 0.0, timed: 0.0 }
    }

    /// Adds a step, and says what is known then; nothing where the next step is to be measured too.
    ///
    /// The first steps are not timed: a machine that takes a state over searches for its pairs anew and makes its
    /// buffers. A trial ends as soon as the machine cannot pay any more, and where another step as long as the last one
    /// would cost more than is allowed.
    pub(super) fn add(&mut self, seconds: f64, settings: &Settings) -> Option<Verdict> {
        self.steps += 1;
        self.in_steps += seconds;
        let timed = self.steps.saturating_sub(settings.warm_up);
        if timed > 0 {
            self.timed += seconds;
        }
        let mean = if timed > 0 { self.timed / f64::from(timed) } else { self.in_steps / f64::from(self.steps) };
        let pays = settings.pays * self.rival;
        if self.timed > f64::from(settings.trial_steps) * pays {
            return Some(Verdict::DoesNotPay(mean));
        }
        if timed >= settings.trial_steps {
            return Some(if mean <= pays { Verdict::Pays(mean) } else { Verdict::DoesNotPay(mean) });
        }
        let with_another = self.in_steps + seconds - f64::from(self.steps + 1) * self.rival;
        (with_another > self.allowed).then_some(Verdict::DoesNotPay(mean.max(pays)))
    }

    /// Seconds that its steps would have taken on the rival.
    pub(super) fn saved(&self) -> f64 {
        f64::from(self.steps) * self.rival
    }
}
