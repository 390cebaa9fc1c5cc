//! Test: the number of empty pair slots changes no bit of a result.

use super::{problem, with_empty_slots};
use crate::gpu::{precisions, test_device};
use crate::lcp::gpu::{DeviceProblem, Solver};
use crate::lcp::{Settings, SolverKind};

/// A run and a run resumed from its state have different empty slots. Both must choose the same path, because the paths
/// round differently.
#[test]
fn a_resumed_run_with_more_empty_slots_is_solved_in_the_same_way() {
    let Some(gpu) = test_device() else { return };
    let problem = problem::<6>(11, 40, 2);
    let settings = Settings { tolerance: 1e-6, max_iterations: 1000 };
    for precision in precisions(gpu) {
        for largest in [39, 60] {
            let mut results = Vec::new();
            for doublings in [0, 4] {
                let (mut on_device, _) = DeviceProblem::upload(gpu, precision, &problem, &[]).unwrap();
                (0..doublings).for_each(|_| with_empty_slots(gpu, &mut on_device));
                assert!(doublings == 0 || on_device.pairs > 60);
                let mut solver = Solver::new(gpu, precision, false, SolverKind::Auto, settings).unwrap();
                solver.set_largest_small(largest);
                let outcome = solver.solve(gpu, &mut on_device).unwrap();
                let gamma = gpu.record().read(&[(&on_device.gamma, 0..40 * precision.bytes() as u64)]).unwrap();
                results.push((outcome, gamma));
            }
            assert_eq!(results[0], results[1], "{} largest small {largest}", precision.name());
        }
    }
}
