//! Iterations of a heap of 200 spheres that falls into a box: `cargo test --release --lib friction::tests::counts --
//! --ignored --nocapture`, for docs/notes/friction-solver.md.

use super::spheres::{Step, heap};
use super::*;

/// Prints the counts of the last 200 of 300 steps.
#[test]
#[ignore = "prints iteration counts and asserts nothing: run it with --ignored --nocapture"]
fn iterations_of_a_heap() {
    for (mu, slip) in [(0.2, 1e-4), (0.5, 1e-4), (0.5, 0.0), (1.0, 1e-4)] {
        for kind in KINDS {
            let gravity = glam::DVec3::new(0.0, 0.0, -9.81);
            let step = Step { dt: 0.01, friction: mu, gravity, slip, near: 0.1 };
            let mut spheres = heap(5, 8);
            let mut solver = Solver::new(kind, Settings { tolerance: 1e-6, max_iterations: 4_000 });
            let outcomes: Vec<Outcome> = (0..300).map(|_| spheres.step(&step, &mut solver)).skip(100).collect();
            let mut counts: Vec<u64> = outcomes.iter().map(|outcome| outcome.iterations).collect();
            counts.sort_unstable();
            let unsolved = outcomes.iter().filter(|outcome| outcome.status != Status::Solved).count();
            let (mean, contacts) = (counts.iter().sum::<u64>() / 200, spheres.contacts(step.near).len());
            println!(
                "mu {mu}, slip {slip:e}, {kind:?}: median {}, mean {mean}, most {}, unsolved {unsolved}, {contacts} contacts",
                counts[100], counts[199]
            );
        }
    }
}
