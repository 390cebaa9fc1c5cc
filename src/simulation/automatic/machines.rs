//! What the chooser asks of a simulation and of its clock. Tests play both.

use super::{Leg, Machine};
use crate::step::{Fault, StepReport};

/// What the chooser asks of a simulation and of its clock.
pub(super) trait Machines {
    /// Seconds from any moment.
    fn now(&self) -> f64;
    /// Accepted steps.
    fn steps(&self) -> u64;
    /// Bodies after them.
    fn bodies(&self) -> usize;
    /// Takes a step on the machine in use.
    fn step(&mut self) -> Result<StepReport, Fault>;
    /// Waits until all that the machine in use was given is done.
    fn finish(&mut self) -> Result<(), Fault>;
    /// Keeps the state, to go back to it where the device fails.
    fn keep(&mut self) -> Result<(), Fault>;
    /// Hands the state over to this machine, which is made ready where it is not. After a fault nothing has changed.
    fn go_to(&mut self, machine: Machine) -> Result<(), Fault>;
    /// Goes back to the CPU with the state after `steps` steps, from a device that failed.
    fn fall_back(&mut self, steps: u64) -> Result<(), Fault>;
    /// Records what computes from here on; the adapter, step, time and bodies are filled in.
    fn record(&mut self, leg: Leg);
}
