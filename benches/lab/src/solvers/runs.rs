//! Short runs of built-in scenes with every solver.

use super::Size;
use super::instance::computed_by;
use crate::StudyError;
use relcp::internals::simulation;
use relcp::record::decode;
use relcp::scene::{Scene, SolverKind};
use relcp::simulation::Compute;
use relcp::step::{Fault, State};
use serde::Serialize;

/// The largest number of bodies for the exact solver. It is meant for some hundred rows, and every step has several
/// solves.
const MOST_BODIES_OF_DENSE: usize = 100;

/// The largest number of recursions of a step, so that solvers that do not converge end soon. Solvers that converge
/// need fewer.
pub(super) const MOST_RECURSIONS: u32 = 8;

/// A run: a built-in scene, its changed settings, and its initial state if that is a stored one.
struct Case {
    name: &'static str,
    scene: &'static str,
    sets: &'static [&'static str],
    state: Option<&'static [u8]>,
    /// Steps for one of [`Size::steps`].
    steps: u64,
}

const CASES: &[Case] = &[
    Case { name: "three-capsules", scene: "three-capsules", sets: &[], state: None, steps: 8 },
    Case { name: "two-ellipsoids", scene: "two-ellipsoids", sets: &["time.dt=0.1"], state: None, steps: 80 },
    Case { name: "chainmail", scene: "chainmail", sets: &["time.dt=0.05"], state: None, steps: 10 },
    Case {
        name: "colony of 1,024",
        scene: "colony-full",
        sets: &["time.dt=0.001", "time.end=1"],
        state: Some(include_bytes!("../../../../assets/states/colony-1024.npz")),
        steps: 1,
    },
    Case {
        name: "compaction of 1,000",
        scene: "compaction",
        sets: &[],
        state: Some(include_bytes!("../../../../assets/states/compaction-1000.npz")),
        steps: 1,
    },
];

/// The results of a solver in a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunRow {
    /// The run.
    pub run: String,
    /// The solver's name in a scene.
    pub solver: String,
    /// The device, or the CPU.
    pub computed_by: String,
    /// The reason of a refusal.
    pub refused: Option<String>,
    /// Bodies at the end.
    pub bodies: usize,
    /// Steps taken.
    pub steps: u64,
    /// Rows of the last LCP.
    pub constraints: usize,
    /// Recursions per step.
    pub recursions: f64,
    /// Applications of `A` per step.
    pub products: f64,
    /// Solves that did not reach the tolerance.
    pub unconverged: u32,
    /// The largest overlap of all steps, a length.
    pub max_overlap: f64,
    /// Milliseconds of the solves per step.
    pub solve_milliseconds: f64,
}

/// Runs every case with every solver on each of `computes`. `said` is called with each row.
///
/// # Errors
/// [`StudyError`] for an invalid scene or state, which tests exclude, and for a device fault.
pub fn run_cases(size: &Size, computes: &[Compute], mut said: impl FnMut(&RunRow)) -> Result<Vec<RunRow>, StudyError> {
    let mut rows = Vec::new();
    for case in CASES {
        for compute in computes {
            for (solver, _) in super::solvers() {
                let row = run(case, &solver, size, compute)?;
                said(&row);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

fn run(case: &Case, solver: &str, size: &Size, compute: &Compute) -> Result<RunRow, StudyError> {
    let mut sets: Vec<String> = case.sets.iter().map(|set| (*set).to_owned()).collect();
    sets.push(format!("solver.kind={solver}"));
    sets.push(format!("solver.max_iterations={}", size.run_iterations));
    sets.push(format!("contact.max_recursions={MOST_RECURSIONS}"));
    let scene = Scene::load(case.scene, &sets)?;
    let bodies = match case.state {
        Some(state) => decode(state)?.1.bodies,
        None => scene.build()?,
    };
    let exact = scene.solver.kind == SolverKind::Dense && bodies.len() > MOST_BODIES_OF_DENSE;
    let mut row = RunRow {
        run: case.name.into(),
        solver: solver.into(),
        computed_by: computed_by(compute),
        refused: None,
        bodies: bodies.len(),
        steps: 0,
        constraints: 0,
        recursions: 0.0,
        products: 0.0,
        unconverged: 0,
        max_overlap: 0.0,
        solve_milliseconds: 0.0,
    };
    if exact {
        return Ok(RunRow {
            refused: Some(format!("too large, it is given at most {MOST_BODIES_OF_DENSE} bodies")),
            ..row
        });
    }
    let mut simulation = match simulation::start(compute, scene, State::new(bodies)) {
        Ok(simulation) => simulation,
        Err(fault @ Fault::Device(relcp::gpu::GpuError::Unsupported { .. })) => {
            return Ok(RunRow { refused: Some(fault.to_string()), ..row });
        }
        Err(fault) => return Err(fault.into()),
    };
    for _ in 0..case.steps * size.steps {
        if simulation.done() {
            break;
        }
        let report = simulation.step()?;
        row.steps += 1;
        row.constraints = report.constraints;
        row.recursions += f64::from(report.recursions);
        row.products += report.products as f64;
        row.unconverged += report.unconverged;
        row.max_overlap = row.max_overlap.max(report.max_overlap);
        row.solve_milliseconds += 1e3 * report.phases.solve.as_secs_f64();
    }
    row.bodies = simulation.bodies();
    let steps = row.steps.max(1) as f64;
    row.recursions /= steps;
    row.products /= steps;
    row.solve_milliseconds /= steps;
    Ok(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Size = Size { iterations: 500, run_iterations: 500, steps: 1, ..Size::QUICK };

    #[test]
    fn every_solver_gets_through_a_small_run() {
        for (solver, _) in crate::solvers::solvers() {
            let row = run(&CASES[0], &solver, &SMALL, &Compute::Cpu).unwrap();
            assert_eq!((row.steps, row.bodies, row.unconverged, &row.refused), (8, 3, 0, &None), "{solver}");
            assert!(row.products >= 1.0 && row.max_overlap <= 1e-5, "{row:?}");
        }
    }

    #[test]
    fn every_run_can_be_begun_and_the_exact_solver_is_kept_from_large_ones() {
        let none = Size { steps: 0, ..SMALL };
        for case in CASES {
            let row = run(case, "pair_block_cg", &none, &Compute::Cpu).unwrap();
            assert!(row.bodies >= 2 && row.refused.is_none(), "{row:?}");
            let dense = run(case, "dense", &none, &Compute::Cpu).unwrap();
            assert_eq!(dense.refused.is_some(), row.bodies > MOST_BODIES_OF_DENSE, "{dense:?}");
        }
    }
}
