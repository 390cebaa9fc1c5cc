//! When the machine that is not in use is tried, and which one goes on.
//!
//! It knows machines by a few verbs and time by a clock, so that tests play both. A trial takes real steps, from which
//! the run goes on. It is made where the scene has changed since the last one, and where all that trials cost stays a
//! small part of the run's time so far. This is the break-even rule of renting or buying (A. R. Karlin, M. S. Manasse,
//! L. Rudolph, D. D. Sleator, "Competitive snoopy caching", 1988): to look for something better costs at most a fixed
//! part of what was spent without it.

use super::machines::Machines;
use super::trial::{Trial, Verdict};
use super::{Leg, Machine, Reason, Settings};
use crate::gpu::GpuError;
use crate::step::{Fault, StepReport};
use std::collections::VecDeque;

/// Seconds that a device's step is taken to last at most, before one was measured: a part that hands over its work, and
/// a multiple of the CPU's step. The former is 15 times the step of 1,024 cells on one core, as was seen on a large GPU
/// for a small colony; the latter is that of the slowest device that a trial is to keep within the loss allowed.
const FIRST_LATENCY: f64 = 0.1;
const FIRST_SLOWNESS: f64 = 10.0;

/// A growth of the bodies, or of the time of the CPU's step, that makes a trial of the device worth while.
const GROWTH: f64 = 2.0;

/// A fall of the time of the device's step that makes a trial of the CPU worth while: a smaller change, as most of a
/// device's time may not depend on the work.
const FALL: f64 = 0.75;

/// Without such a change a trial is made again when the run has taken this many times as long: the first steps of a
/// scene may differ from later ones.
const LATER: f64 = 3.0;

/// The last steps that tell whether a device has become slow.
const LATELY: usize = 4;

/// How much longer the CPU's step may last than is expected from the last trial and the number of bodies.
const CPU_SLACK: f64 = 2.0;

/// What the last trial found.
#[derive(Clone, Copy, Debug)]
struct Compared {
    bodies: usize,
    /// Seconds of a step.
    cpu: f64,
    gpu: f64,
    /// What the run had taken.
    spent: f64,
}

/// Chooses between the CPU and a device.
#[derive(Clone, Debug)]
pub(super) struct Chooser {
    settings: Settings,
    on: Machine,
    /// Whether the device is not to be used any more.
    out: bool,
    /// The last steps of the machine in use, seconds.
    recent: VecDeque<f64>,
    /// Seconds that the run took, without what trials lost.
    spent: f64,
    /// Seconds that trials lost.
    lost: f64,
    /// Whether the device was opened, and its kernels made.
    opened: bool,
    /// Seconds that it last took to go over to each; nothing before the device was gone to a second time.
    to_gpu: Option<f64>,
    to_cpu: f64,
    last: Option<Compared>,
    trial: Option<Trial>,
}

impl Chooser {
    pub(super) fn new(settings: Settings) -> Self {
        Chooser {
            settings,
            on: Machine::Cpu,
            out: false,
            recent: VecDeque::new(),
            spent: 0.0,
            lost: 0.0,
            opened: false,
            to_gpu: None,
            to_cpu: 0.0,
            last: None,
            trial: None,
        }
    }

    /// Counts what the run took before, and what of it trials lost.
    #[cfg(any(test, feature = "files"))]
    pub(super) fn resume(&mut self, seconds: f64, lost: f64) {
        self.spent += (seconds - lost).max(0.0);
        self.lost += lost;
    }

    /// Takes a step, on the machine that suits it.
    pub(super) fn step(&mut self, machines: &mut dyn Machines) -> Result<StepReport, Fault> {
        if self.trial.is_none()
            && let Some(reason) = self.moment(machines.bodies())
        {
            self.begin_trial(machines, reason)?;
        }
        let (before, begun) = (machines.steps(), machines.now());
        match self.timed_step(machines, begun) {
            Ok((report, seconds)) => {
                self.count(machines, seconds)?;
                Ok(report)
            }
            Err(Fault::Device(fault)) if self.on == Machine::Gpu => {
                // Where the state cannot be had, the device's own fault is what counts.
                machines.fall_back(before).map_err(|_| Fault::Device(fault.clone()))?;
                self.give_up(machines, self.trial.map_or(begun, |trial| trial.begun), &fault);
                let begun = machines.now();
                let (report, seconds) = self.timed_step(machines, begun)?;
                self.count(machines, seconds)?;
                Ok(report)
            }
            Err(fault) => Err(fault),
        }
    }

    /// In a trial a step is timed to its very end, and its state is kept.
    fn timed_step(&self, machines: &mut dyn Machines, begun: f64) -> Result<(StepReport, f64), Fault> {
        let report = machines.step()?;
        if self.trial.is_some() {
            machines.finish()?;
        }
        let seconds = machines.now() - begun;
        if self.trial.is_some_and(|trial| trial.of == Machine::Gpu) {
            machines.keep()?;
        }
        Ok((report, seconds))
    }

    /// Counts an accepted step, and ends a trial where enough is known.
    fn count(&mut self, machines: &mut dyn Machines, seconds: f64) -> Result<(), Fault> {
        let settings = self.settings;
        let Some(trial) = &mut self.trial else {
            self.spent += seconds;
            self.recent.push_back(seconds);
            if self.recent.len() > settings.reference_steps {
                self.recent.pop_front();
            }
            return Ok(());
        };
        self.spent += trial.rival;
        let Some(verdict) = trial.add(seconds, &settings) else { return Ok(()) };
        let trial = *trial;
        self.trial = None;
        self.end_trial(machines, &trial, verdict)
    }

    /// Mean of the last steps of the machine in use.
    fn mean(&self, steps: usize) -> f64 {
        let steps = steps.min(self.recent.len()).max(1);
        self.recent.iter().rev().take(steps).sum::<f64>() / steps as f64
    }

    /// Whether trials may cost so much more now.
    fn affords(&self, seconds: f64) -> bool {
        self.lost + seconds <= self.settings.allowed_loss * self.spent
    }

    /// Whether the other machine is tried now, and why.
    fn moment(&self, bodies: usize) -> Option<Reason> {
        if self.out {
            return None;
        }
        match self.on {
            Machine::Cpu => self.moment_for_gpu(bodies),
            Machine::Gpu => self.moment_for_cpu(bodies),
        }
    }

    fn moment_for_gpu(&self, bodies: usize) -> Option<Reason> {
        if bodies < self.settings.least_bodies || self.recent.len() < self.settings.reference_steps {
            return None;
        }
        let own = self.mean(self.settings.reference_steps);
        let reason = match &self.last {
            None => Reason::FirstTrial,
            Some(last) if bodies as f64 >= GROWTH * last.bodies as f64 => Reason::MoreBodies,
            Some(last) if own >= GROWTH * last.cpu => Reason::SlowerSteps,
            Some(last) if self.spent >= LATER * last.spent => Reason::Later,
            Some(_) => return None,
        };
        self.affords(self.way_to_gpu() + self.to_cpu + self.allowed_steps(bodies, Machine::Gpu)).then_some(reason)
    }

    fn moment_for_cpu(&self, bodies: usize) -> Option<Reason> {
        let last = self.last?;
        if self.recent.len() < LATELY {
            return None;
        }
        let expected = last.cpu * (bodies as f64 / last.bodies as f64);
        let moves = self.to_cpu + self.way_to_gpu();
        // A device that has become slow is left without regard to earlier losses, but not at every hiccup.
        let worth = self.settings.allowed_loss * (self.spent - last.spent);
        if self.mean(LATELY) > expected && moves + expected <= worth {
            return Some(Reason::OtherWasFaster);
        }
        let reason = match () {
            () if self.recent.len() < self.settings.reference_steps => return None,
            () if self.mean(self.settings.reference_steps) <= FALL * last.gpu => Reason::FasterSteps,
            () if self.spent >= LATER * last.spent => Reason::Later,
            () => return None,
        };
        self.affords(moves + self.allowed_steps(bodies, Machine::Cpu)).then_some(reason)
    }

    /// Seconds that the steps of a trial may take beyond those of the machine in use: two of the slowest that are
    /// expected, as the first is not timed.
    fn allowed_steps(&self, bodies: usize, of: Machine) -> f64 {
        let own = self.mean(self.settings.reference_steps);
        let slowest = match (of, &self.last) {
            (Machine::Gpu, None) => FIRST_LATENCY + FIRST_SLOWNESS * own,
            (Machine::Gpu, Some(last)) => last.gpu.max(last.gpu * own / last.cpu),
            (Machine::Cpu, None) => own,
            (Machine::Cpu, Some(last)) => CPU_SLACK * last.cpu * (bodies as f64 / last.bodies as f64).max(1.0),
        };
        f64::from(self.settings.warm_up + 1) * slowest
    }

    fn begin_trial(&mut self, machines: &mut dyn Machines, reason: Reason) -> Result<(), Fault> {
        let (begun, bodies, of) = (machines.now(), machines.bodies(), self.on.other());
        let steps = if reason == Reason::OtherWasFaster { LATELY } else { self.settings.reference_steps };
        let rival = self.mean(steps);
        let trial = Trial::new(of, begun, rival, self.allowed_steps(bodies, of));
        match machines.go_to(of) {
            Ok(()) => {}
            Err(Fault::Device(fault)) if of == Machine::Gpu => {
                self.give_up(machines, begun, &fault);
                return Ok(());
            }
            Err(fault) => return Err(fault),
        }
        self.moved(machines.now() - begun, of);
        self.trial = Some(trial);
        machines.record(self.leg(reason, self.last.map(|last| (last.cpu, last.gpu))));
        Ok(())
    }

    /// The trial's machine goes on, or the one before it does.
    fn end_trial(&mut self, machines: &mut dyn Machines, trial: &Trial, verdict: Verdict) -> Result<(), Fault> {
        let (Verdict::Pays(tried) | Verdict::DoesNotPay(tried)) = verdict;
        let (cpu, gpu) = if trial.of == Machine::Gpu { (trial.rival, tried) } else { (tried, trial.rival) };
        let mut reason = Reason::Faster;
        if verdict == Verdict::DoesNotPay(tried) {
            reason = Reason::NotSlower;
            let (begun, back) = (machines.now(), trial.of.other());
            match machines.go_to(back) {
                Ok(()) => self.moved(machines.now() - begun, back),
                Err(Fault::Device(fault)) if back == Machine::Gpu => {
                    self.give_up(machines, begun, &fault);
                    return Ok(());
                }
                Err(fault) => return Err(fault),
            }
        }
        self.lost += (machines.now() - trial.begun - trial.saved()).max(0.0);
        self.last = Some(Compared { bodies: machines.bodies(), cpu, gpu, spent: self.spent });
        machines.record(self.leg(reason, Some((cpu, gpu))));
        Ok(())
    }

    /// Takes note that the state was handed over to a machine, in so many seconds.
    fn moved(&mut self, seconds: f64, to: Machine) {
        match to {
            Machine::Cpu => self.to_cpu = seconds,
            // The first time the device was opened, which says nothing of the next time.
            Machine::Gpu if !self.opened => self.opened = true,
            Machine::Gpu => self.to_gpu = Some(seconds),
        }
        self.on = to;
        self.recent.clear();
    }

    /// Seconds that it is expected to take to go over to the device.
    fn way_to_gpu(&self) -> f64 {
        let way_back = if self.opened { self.to_cpu } else { self.settings.opening };
        self.to_gpu.unwrap_or(way_back)
    }

    /// Goes on without the device, whose use began at `begun` and came to nothing.
    fn give_up(&mut self, machines: &mut dyn Machines, begun: f64, fault: &GpuError) {
        let saved = self.trial.take().map_or(0.0, |trial| trial.saved());
        self.lost += (machines.now() - begun - saved).max(0.0);
        (self.on, self.out) = (Machine::Cpu, true);
        self.recent.clear();
        // That there is no device is nothing to tell.
        if !matches!(fault, GpuError::NoAdapter { .. } | GpuError::NotBuilt) {
            let leg = self.leg(Reason::Failed, self.last.map(|last| (last.cpu, last.gpu)));
            machines.record(Leg { message: Some(fault.to_string()), ..leg });
        }
    }

    fn leg(&self, reason: Reason, seconds: Option<(f64, f64)>) -> Leg {
        Leg {
            cpu_seconds: seconds.map(|(cpu, _)| cpu),
            gpu_seconds: seconds.map(|(_, gpu)| gpu),
            lost_seconds: self.lost,
            ..Leg::first(self.on, reason)
        }
    }
}
