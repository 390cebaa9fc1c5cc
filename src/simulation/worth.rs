//! Whether a hardware GPU may be faster than the CPU. This is the one place that compares the two. It only prints a
//! hint: the run uses the backend that was chosen, and no result depends on a clock.

use super::Compute;
use crate::gpu::{Choice, adapters};
use crate::scene::Scene;

/// The number of bodies from which a hardware GPU is worth trying. An NVIDIA H200 takes 1.2 times as long as 16 threads
/// of its host for a step of a crowded colony of 4,096 cells, and a third of the time at 8,192. One thread takes
/// longer.
const LEAST_BODIES: f64 = 4096.0;

/// A hint for `runs` concurrent runs on the CPU that a hardware GPU may be faster. None if there are few bodies, if
/// devices do not support the scene or leave its solves to the CPU, or if there is no hardware adapter. It lists
/// adapters only for many bodies, and opens none.
pub fn worth_a_device(scene: &Scene, runs: usize) -> Option<String> {
    let bodies = runs as f64 * scene.bodies_at_end();
    if bodies < LEAST_BODIES || Compute::check(scene).is_err() || Compute::host_solves(scene) {
        return None;
    }
    let adapter = adapters(&Choice::default()).into_iter().find(|adapter| adapter.taken && adapter.is_hardware())?;
    let name = adapter.name;
    Some(format!("with {LEAST_BODIES} bodies or more a GPU may be faster than the CPU, and this machine has {name}"))
}

#[cfg(all(test, feature = "files"))]
mod tests {
    use super::*;

    #[test]
    fn growing_cells_are_counted_at_their_end() {
        let colony = Scene::load("colony", ["time.end=4"]).unwrap();
        assert!((50.0..60.0).contains(&colony.bodies_at_end()));
        let stopped = Scene::load("colony", ["growth.stop.population=20"]).unwrap();
        assert_eq!(stopped.bodies_at_end(), 20.0);
        let packed = Scene::load("compaction", ["time.end=4"]).unwrap();
        assert_eq!(packed.bodies_at_end(), 1000.0);
    }

    #[test]
    fn a_device_is_not_proposed_for_few_bodies_nor_for_what_it_cannot_do() {
        let scene = |set: &str| Scene::load("colony", ["time.end=4", set]).unwrap();
        assert_eq!(worth_a_device(&scene("time.dt=0.01"), 64), None);
        assert_eq!(worth_a_device(&scene("solver.kind=dense"), 1_000_000), None);
        assert_eq!(worth_a_device(&scene("contact.friction=0.3"), 1_000_000), None);
    }
}
