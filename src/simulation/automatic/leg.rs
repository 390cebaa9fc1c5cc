//! What computed which steps of a simulation.

use crate::gpu::Precision;
use std::fmt;

/// What takes steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Machine {
    /// The CPU.
    Cpu,
    /// A device.
    Gpu,
}

impl Machine {
    /// The one of the two that this is not.
    pub fn other(self) -> Machine {
        match self {
            Machine::Cpu => Machine::Gpu,
            Machine::Gpu => Machine::Cpu,
        }
    }

    /// Its name in `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            Machine::Cpu => "cpu",
            Machine::Gpu => "gpu",
        }
    }

    /// Its name in sentences.
    fn in_words(self) -> &'static str {
        match self {
            Machine::Cpu => "CPU",
            Machine::Gpu => "GPU",
        }
    }
}

/// Why a machine takes the steps from here on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Reason {
    /// It was asked for.
    AskedFor,
    /// A run whose machine is chosen by measuring begins on the CPU, and goes on there when it is resumed.
    Begins,
    /// A trial: the first one, as there are bodies enough.
    FirstTrial,
    /// A trial: twice as many bodies as at the last one.
    MoreBodies,
    /// A trial: steps take twice the time that they took at the last one.
    SlowerSteps,
    /// A trial: steps of the device take three quarters of the time that they took at the last one.
    FasterSteps,
    /// A trial: steps take longer than the other machine took at the last one.
    OtherWasFaster,
    /// A trial: the last one is long ago.
    Later,
    /// It was faster in its trial.
    Faster,
    /// The other machine was not faster in its trial.
    NotSlower,
    /// The other machine failed or cannot be used.
    Failed,
}

impl Reason {
    /// Whether steps are taken to be measured.
    pub fn is_trial(self) -> bool {
        matches!(
            self,
            Reason::FirstTrial
                | Reason::MoreBodies
                | Reason::SlowerSteps
                | Reason::FasterSteps
                | Reason::OtherWasFaster
                | Reason::Later
        )
    }
}

/// Steps that one machine took, or takes, one after the other.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Leg {
    /// The machine.
    pub machine: Machine,
    /// The device's adapter; null on the CPU.
    pub adapter: Option<String>,
    /// The numbers that it computes with: `f32` or `f64`.
    pub precision: String,
    /// The first step that it takes.
    pub from_step: u64,
    /// The time before that step.
    pub time: f64,
    /// The bodies before that step.
    pub bodies: usize,
    /// Why it takes them.
    pub reason: Reason,
    /// Wall time of a step on the CPU as last measured, in seconds; null where it was not.
    pub cpu_seconds: Option<f64>,
    /// Wall time of a step on the device as last measured, in seconds; null where it was not.
    pub gpu_seconds: Option<f64>,
    /// Wall time of the run that trials cost so far beyond what the machine in use would have taken, in seconds.
    pub lost_seconds: f64,
    /// What one should know: why the device is not used, or a warning about it; null where there is nothing.
    pub message: Option<String>,
}

impl Leg {
    /// That of a simulation that begins on, or is taken up by, a machine.
    pub(crate) fn first(machine: Machine, reason: Reason) -> Leg {
        Leg {
            machine,
            adapter: None,
            precision: Precision::F64.name().into(),
            from_step: 1,
            time: 0.0,
            bodies: 0,
            reason,
            cpu_seconds: None,
            gpu_seconds: None,
            lost_seconds: 0.0,
            message: None,
        }
    }

    /// Whether its steps are taken to be measured.
    pub fn is_trial(&self) -> bool {
        self.reason.is_trial()
    }

    /// Whether it follows a trial that changed nothing.
    pub fn is_return(&self) -> bool {
        self.reason == Reason::NotSlower
    }
}

/// A sentence: who takes over, where, and why.
impl fmt::Display for Leg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let machine = match &self.adapter {
            Some(adapter) => format!("{adapter} in {}", self.precision),
            None => format!("the {}", self.machine.in_words()),
        };
        write!(f, "from step {} with {} bodies: {machine}", self.from_step, self.bodies)?;
        match self.reason {
            Reason::AskedFor => write!(f, ", as asked for")?,
            Reason::Begins => {}
            Reason::Failed => write!(f, ", as the GPU cannot be used")?,
            trial if trial.is_trial() => write!(f, ", to measure it")?,
            Reason::Faster => write!(f, ", which is faster")?,
            _ => write!(f, ", as the {} is not faster", self.machine.other().in_words())?,
        }
        if let (Some(cpu), Some(gpu)) = (self.cpu_seconds, self.gpu_seconds) {
            let [cpu, gpu] = [cpu, gpu].map(|seconds| 1e3 * seconds);
            write!(f, " (a step: {cpu:.3} ms on the CPU, {gpu:.3} ms on the GPU)")?;
        }
        match &self.message {
            Some(message) => write!(f, ": {message}"),
            None => Ok(()),
        }
    }
}
