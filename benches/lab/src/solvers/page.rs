//! The page and the tables of the study.

use super::{Attempt, Instance, Reference, RunRow, Size, Start, TOLERANCES};
use crate::StudyError;
use crate::table::csv_table;
use relcp::lcp::Status;
use std::fmt::Write as _;

/// Returns the page: the measurements and the machine.
pub fn page(instances: &[Instance], runs: &[RunRow], size: &Size) -> String {
    let mut out = String::from("# Solvers\n\n");
    let computed_by = instances.iter().flat_map(|i| &i.attempts).map(|a| &a.computed_by);
    let mut computed_by: Vec<&String> = computed_by.chain(runs.iter().map(|run| &run.computed_by)).collect();
    computed_by.sort();
    computed_by.dedup();
    for name in &computed_by {
        let _ = writeln!(out, "* Computed by {name}.");
    }
    let build =
        if cfg!(debug_assertions) { "a build with debug assertions, so times are long" } else { "a release build" };
    let _ = writeln!(
        out,
        "* Program {}, {build}, {} threads, {} {}.\n* A product is one application of `A`; one sweep of projected Gauss-Seidel and one step of the \
         exact solver count as one. Times are of this machine in this run, all preparation counted; of short solves the shortest of three.\n\
         * A residual is `max |min(q + A gamma, s gamma)|`, a length, computed anew from `q`, `J` and `gamma`. `-`: not reached within {} iterations.\n\
         * The error of a velocity `v = J^T gamma` is `|v - reference| / |reference|`.",
        env!("CARGO_PKG_VERSION"),
        rayon::current_num_threads(),
        std::env::consts::ARCH,
        std::env::consts::OS,
        size.iterations
    );
    if !instances.is_empty() {
        out.push_str("\n## Stored LCPs\n");
    }
    for instance in instances {
        for name in &computed_by {
            let attempts: Vec<&Attempt> = instance.attempts.iter().filter(|a| a.computed_by == **name).collect();
            if !attempts.is_empty() {
                write_instance(&mut out, instance, &attempts, name);
            }
        }
    }
    if !runs.is_empty() {
        write_runs(&mut out, runs, size);
    }
    out
}

fn write_instance(out: &mut String, instance: &Instance, attempts: &[&Attempt], computed_by: &str) {
    let small = |x: Option<f64>| x.map_or("not finite".into(), |x| format!("{x:.1e}"));
    let reference = match instance.reference {
        Reference::Stored => "the stored one",
        Reference::Made => "made here, as the stored multipliers are no solution",
        Reference::None => "none was found",
    };
    let _ = write!(
        out,
        "\n### {} on {computed_by}\n\n{} rows of {} pairs, {} bodies of {} unknowns. Residual of the stored start {}, of the stored multipliers {}. Reference \
         velocity: {reference}.\n\n| solver | start |",
        instance.lcp,
        instance.rows,
        instance.pairs,
        instance.bodies,
        instance.unknowns,
        small(instance.start_residual),
        small(instance.stored_residual)
    );
    for tolerance in TOLERANCES {
        let _ = write!(out, " products to {tolerance:.0e} (ms) |");
    }
    out.push_str(" residual then | error of v then |\n| --- | --- | ---: | ---: | ---: | ---: | ---: |\n");
    for group in attempts.chunk_by(|a, b| a.solver == b.solver && a.start == b.start) {
        let [first, .., last] = group else { continue };
        let _ = write!(out, "| {} | {} |", first.solver, first.start.name());
        for attempt in group {
            let _ = write!(out, " {} |", cell(attempt));
        }
        let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.1e}"));
        let _ = writeln!(out, " {} | {} |", number(last.residual), number(last.velocity_error));
    }
    let mut refused: Vec<String> = Vec::new();
    for attempt in attempts.iter().filter(|attempt| attempt.start == Start::Cold) {
        let line = attempt.refused.as_ref().map(|why| format!("{}: {why}", attempt.solver));
        refused.extend(line.filter(|line| refused.last() != Some(line)));
    }
    if !refused.is_empty() {
        let _ = writeln!(out, "\nRefused: {}.", refused.join("; "));
    }
}

fn cell(attempt: &Attempt) -> String {
    if attempt.refused.is_some() {
        return "refused".into();
    }
    match attempt.status == Status::Solved.name() {
        true => format!("{} ({:.1})", attempt.products, attempt.milliseconds),
        false => format!("- ({:.1})", attempt.milliseconds),
    }
}

fn write_runs(out: &mut String, runs: &[RunRow], size: &Size) {
    let _ = write!(
        out,
        "\n## Runs\n\nBuilt-in scenes, tolerances their own (residual 1e-6, overlap 1e-5), at most {} iterations a solve and {} recursions a step. Where solves do not converge, the \
         trial that follows is a poor one, which the recursions make up for where they can.\n\n| run | bodies | steps | solver | computed by | rows | recursions a \
         step | products a step | ms of solves a step | unconverged solves | worst overlap |\n| --- | ---: | ---: | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n",
        size.run_iterations,
        super::runs::MOST_RECURSIONS
    );
    for run in runs {
        let _ = write!(out, "| {} | {} | {} | {} | {} |", run.run, run.bodies, run.steps, run.solver, run.computed_by);
        let _ = match &run.refused {
            Some(why) => writeln!(out, " refused: {why} | | | | | |"),
            None => writeln!(
                out,
                " {} | {:.2} | {:.0} | {:.2} | {} | {:.1e} |",
                run.constraints, run.recursions, run.products, run.solve_milliseconds, run.unconverged, run.max_overlap
            ),
        };
    }
}

/// The solves as CSV.
///
/// # Errors
/// [`StudyError::Table`].
pub fn attempts_csv(instances: &[Instance]) -> Result<Vec<u8>, StudyError> {
    csv_table(instances.iter().flat_map(|instance| &instance.attempts))
}

/// The runs as CSV.
///
/// # Errors
/// [`StudyError::Table`].
pub fn runs_csv(runs: &[RunRow]) -> Result<Vec<u8>, StudyError> {
    csv_table(runs.iter())
}
