//! The devices that compute the members of a batch: one ensemble, or on a software adapter one device per thread.

use super::arguments::Compute as Arguments;
use super::exit::CliError;
use super::{compute, driver};
use relcp::gpu::{Ensemble, Gpu, Precision};
use relcp::scene::Scene;
use relcp::simulation::Compute;
use std::sync::{Arc, Mutex, PoisonError};

/// Members that run concurrently on a device. They share the cost of a launch, and each takes one thread of the host.
pub(super) const MEMBERS_AT_ONCE: usize = 64;

/// See the module.
pub(super) struct Devices {
    ensembles: Mutex<Vec<Ensemble>>,
    pub precision: Precision,
}

impl Devices {
    /// Opens the devices that the arguments request, for a scene of the batch; none if the CPU computes.
    pub fn open(arguments: &Arguments, scene: &Scene, threads: usize) -> Result<Option<Devices>, CliError> {
        let Compute::Gpu { gpu, precision } = compute::settle(arguments, scene)? else { return Ok(None) };
        let others = driver::devices_of_many(&gpu, threads) - 1;
        let mut ensembles = vec![Ensemble::new(gpu)?];
        for _ in 0..others {
            if let Compute::Gpu { gpu, .. } = compute::settle(arguments, scene)? {
                ensembles.push(Ensemble::new(gpu)?);
            }
        }
        Ok(Some(Devices { ensembles: Mutex::new(ensembles), precision }))
    }

    /// The device of one more member, in the ensemble with the fewest members.
    pub fn member(&self) -> Arc<Gpu> {
        // One caller at a time, so that each counts the members of earlier callers.
        let ensembles = self.ensembles.lock().unwrap_or_else(PoisonError::into_inner);
        let fewest = ensembles.iter().enumerate().min_by_key(|(nth, ensemble)| (ensemble.members(), *nth));
        let (nth, _) = fewest.unwrap_or((0, &ensembles[0]));
        ensembles[nth].member()
    }

    /// The number of concurrent members, by option or by default.
    pub fn jobs(&self, asked: Option<usize>, bodies: u64) -> Result<usize, CliError> {
        let ensembles = self.ensembles.lock().unwrap_or_else(PoisonError::into_inner);
        let fit: u64 = ensembles.iter().map(|ensemble| ensemble.members_that_fit(bodies)).sum();
        let fit = (fit as usize).max(1);
        match asked {
            Some(asked) if asked > fit => Err(CliError::Usage(format!(
                "--jobs: {asked} members of about {bodies} bodies do not fit on the device at once; at most {fit} fit"
            ))),
            Some(asked) => Ok(asked),
            None => Ok(MEMBERS_AT_ONCE.min(fit)),
        }
    }
}
