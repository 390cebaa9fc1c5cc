//! The devices that compute the members of a batch: one ensemble, or one for each thread on a software adapter.

use super::arguments::{Backend, Compute as Arguments};
use super::exit::CliError;
use super::{compute, driver};
use relcp::gpu::{Ensemble, Gpu, Precision};
use relcp::scene::Scene;
use std::sync::{Arc, Mutex, PoisonError};

/// Members that run on a device at once. A launch is paid once for all of them, and each takes a thread of the host.
const MEMBERS_AT_ONCE: usize = 64;

/// The same for each device of a software adapter, where launches cost little: 64 colonies to 16 to 32 cells on two
/// cores took 15.5, 14.4, 16.6 and 17.7 s with 2, 4, 8 and 32 members a device.
const MEMBERS_OF_A_THREAD: usize = 4;

/// See the module.
pub(super) struct Devices {
    ensembles: Mutex<Vec<Ensemble>>,
    pub precision: Precision,
}

impl Devices {
    /// Those that the arguments ask for, decided by a scene; none where the CPU computes.
    pub fn open(arguments: &Arguments, scene: &Scene, threads: usize) -> Result<Option<Devices>, CliError> {
        let Some((gpu, precision)) = compute::device_of_many(arguments, scene)? else { return Ok(None) };
        let others = driver::devices_of_many(&gpu, threads) - 1;
        let mut ensembles = vec![Ensemble::new(gpu)?];
        let again = Arguments { backend: Backend::Gpu, ..arguments.clone() };
        for _ in 0..others {
            if let Some((gpu, _)) = compute::device_of_many(&again, scene)? {
                ensembles.push(Ensemble::new(gpu)?);
            }
        }
        Ok(Some(Devices { ensembles: Mutex::new(ensembles), precision }))
    }

    /// The device of one more member: of the ensemble that has the fewest.
    pub fn member(&self) -> Arc<Gpu> {
        // One caller at a time, so that each counts the members of those before it.
        let ensembles = self.ensembles.lock().unwrap_or_else(PoisonError::into_inner);
        let fewest = ensembles.iter().enumerate().min_by_key(|(nth, ensemble)| (ensemble.members(), *nth));
        let (nth, _) = fewest.unwrap_or((0, &ensembles[0]));
        ensembles[nth].member()
    }

    /// How many members run at once, where a number is asked for or none.
    pub fn jobs(&self, asked: Option<usize>, bodies: u64, must: bool) -> Result<usize, CliError> {
        let ensembles = self.ensembles.lock().unwrap_or_else(PoisonError::into_inner);
        let best = if ensembles.len() > 1 { MEMBERS_OF_A_THREAD * ensembles.len() } else { MEMBERS_AT_ONCE };
        let fit: u64 = ensembles.iter().map(|ensemble| ensemble.members_that_fit(bodies)).sum();
        let fit = (fit as usize).max(1);
        match asked {
            Some(asked) if asked > fit && must => Err(CliError::Usage(format!(
                "--jobs: {asked} members of some {bodies} bodies do not fit on the device at once; the most is {fit}"
            ))),
            Some(asked) => Ok(asked.min(fit)),
            None => Ok(best.min(fit)),
        }
    }
}
