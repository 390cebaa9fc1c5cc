//! The page of the study.

use super::engines::{self, Engine, GYRATION_WITHIN, RODS};
use super::lattice::{DIAMETER, END, LENGTH, SEED, SPACING};
use super::{Run, Study};
use crate::machine::machine;
use crate::paper::{COMPUTED_BY, Target, target};
use std::fmt::Write as _;

pub(super) fn page(study: &Study) -> String {
    let runs = study.runs();
    let tolerance = runs.first().map_or(0.0, |run| run.summary.overlap_tolerance);
    let mut out = format!(
        "# Packing\n\n\
         Rods are drawn from a lattice into a ball: what a step takes and how much the smooth surfaces overlap, by the step's size, beside public engines on the same \
         scene. Not a test of the paper.\n\n\
         * Scene: spherocylinders of radius {} and length {LENGTH} from tip to tip on a cubic lattice of spacing {SPACING}, orientations drawn from seed {SEED}; overdamped, \
         translational mobility 1 and rotational 12/L^2 (drag 1/L); the paper's inward field (`radial_inward`, a speed of about 1 far from the centre); to time {END}. Each scene is beside this page as \
         `packing-N-scene.json`: `relcp run packing-{RODS}-scene.json --set time.dt=0.02`.\n\
         * Settings: ReLCP, overlap tolerance {tolerance:.0e}, the default solver. Made by `cargo run --release -p relcp-lab -- packing`.\n\
         * {}. Computed by {COMPUTED_BY}.\n\
         * CPU ms: the processor's time of all threads, the clock's where the system does not tell it; wall ms: the clock's, on a machine that may have been shared. Overlaps are true ones of the \
         smooth surfaces: at most after any step, and at the end computed afresh from the bodies alone.\n",
        0.5 * DIAMETER,
        machine(),
    );
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target::table(&study.targets()));
    ours(&mut out, runs);
    theirs(&mut out, study.engines());
    out
}

fn ours(out: &mut String, runs: &[Run]) {
    out.push_str(
        "\n## Ours\n\n| rods | dt | steps | CPU ms a step | wall ms a step | CPU s to the end | overlap, at most | overlap, at the end | radius of gyration | recursions a step | \
         products a step | rows, mean | rows, at the end |\n| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for Run { summary, gyration } in runs {
        let steps = summary.steps.max(1) as f64;
        let _ = writeln!(
            out,
            "| {} | {} | {} | {:.2} | {:.2} | {:.1} | {:.1e} | {:.1e} | {} | {:.2} | {:.0} | {:.0} | {} |",
            summary.bodies,
            summary.dt,
            summary.steps,
            summary.step_milliseconds(),
            summary.wall_milliseconds / steps,
            1e-3 * summary.milliseconds,
            summary.max_overlap,
            summary.last_overlap,
            gyration.map_or(String::new(), |gyration| format!("{gyration:.4}")),
            summary.recursions as f64 / steps,
            summary.products as f64 / steps,
            summary.constraints,
            summary.last_constraints,
        );
    }
}

/// Writes the results of `benches/peers/run` for this program and for engines, measured in one call.
fn theirs(out: &mut String, engines: &[Engine]) {
    let origin = engines.first().map_or(String::new(), |run| format!("{}, {}", run.date, run.machine));
    let _ = write!(
        out,
        "\n## Public engines\n\nMeasured by `benches/peers/run`, this program in the same go: {origin}, one thread on one core. {RODS} rods of the same sizes, lattice and field, with orientations of \
         another draw; overlaps are found by a checker of its own, in f64. None of the engines is a dependency of this program. All their settings, and how they were chosen, \
         are in [peers.md](../../peers.md). A run whose radius of gyration is more than {:.0}% from ours ends elsewhere: its overlap is no measure.\n\n\
         | program and settings | dt | CPU ms a step | CPU s to the end | largest overlap | radius of gyration |\n| --- | ---: | ---: | ---: | ---: | ---: |\n",
        100.0 * GYRATION_WITHIN
    );
    for run in engines {
        let _ = write!(out, "| {} | {} |", run.name(), run.dt);
        let _ = match (run.cost(), run.cpu_s, run.gyration) {
            (Some((step, overlap)), Some(all), Some(gyration)) => {
                writeln!(out, " {step:.1} | {all:.1} | {overlap:.1e} | {gyration:.3} |")
            }
            _ => writeln!(out, " | | | {} |", run.ended.as_deref().unwrap_or("not finite")),
        };
    }
}

pub(super) fn targets(runs: &[Run], engines: &[Engine]) -> Vec<Target> {
    let worst = |of: fn(&Run) -> f64| runs.iter().map(of).fold(0.0, f64::max);
    let held = |run: &Run| run.summary.max_overlap.max(run.summary.last_overlap) <= run.summary.overlap_tolerance;
    let mut targets = vec![Target::new(
        "the overlap tolerance is held after every step at every dt, and at the end by an audit",
        format!(
            "{:.3e} at most, {:.3e} at the end",
            worst(|r| r.summary.max_overlap),
            worst(|r| r.summary.last_overlap)
        ),
        (!runs.is_empty()).then(|| runs.iter().all(held)),
    )];
    let all: Vec<&Run> = runs.iter().filter(|run| run.summary.bodies == RODS).collect();
    let least = engines::beside(engines).min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b));
    let radius = least.and_then(|(run, _)| run.gyration).unwrap_or(f64::NAN);
    let found: Vec<(f64, f64)> = all.iter().filter_map(|run| Some((run.summary.dt, run.gyration?))).collect();
    let words = found
        .iter()
        .map(|(dt, gyration)| format!("{gyration:.4} ({:+.2}%) at {dt}", 100.0 * (gyration / radius - 1.0)));
    targets.push(Target::new(
        format!(
            "radius of gyration of {RODS} rods at the end within {:.0}% of {radius:.4}, that of the engine with the least overlap",
            100.0 * GYRATION_WITHIN
        ),
        words.collect::<Vec<_>>().join(", "),
        (!found.is_empty()).then(|| found.iter().all(|(_, found)| (found / radius - 1.0).abs() <= GYRATION_WITHIN)),
    ));
    let least = least.map_or(f64::INFINITY, |(_, (_, overlap))| overlap);
    let most = all.iter().map(|run| run.summary.max_overlap).fold(0.0, f64::max);
    targets.push(Target::new(
        format!("overlap of {RODS} rods at every dt under a tenth of the least of the engines'"),
        if all.is_empty() { String::new() } else { format!("{most:.1e} against {least:.1e}") },
        (!all.is_empty()).then_some(most < 0.1 * least),
    ));
    targets
}
