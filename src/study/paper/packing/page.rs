//! The page of the study.

use super::engines::{ENGINES, GYRATION, RODS};
use super::lattice::{DIAMETER, END, LENGTH, SEED, SPACING};
use super::{Run, Study};
use crate::study::machine::machine;
use crate::study::paper::{COMPUTED_BY, Target, target};
use std::fmt::Write as _;

/// How far the radius of gyration may be from that of the engines' runs, whose orientations were drawn otherwise, a
/// part of it.
const GYRATION_WITHIN: f64 = 0.01;

pub(super) fn page(study: &Study) -> String {
    let runs = study.runs();
    let tolerance = runs.first().map_or(0.0, |run| run.course.overlap_tolerance);
    let mut out = format!(
        "# Packing\n\n\
         Rods are drawn from a lattice into a ball: what a step takes and how much the smooth surfaces overlap, by the step's size, beside public engines on the same \
         scene. Not a test of the paper.\n\n\
         * Scene: spherocylinders of radius {} and length {LENGTH} from tip to tip on a cubic lattice of spacing {SPACING}, orientations drawn from seed {SEED}; overdamped, \
         translational mobility 1 and rotational 12/L^2 (drag 1/L); the paper's inward field (`radial_inward`, a speed of about 1 far from the centre); to time {END}. Each scene is beside this page as \
         `packing-N-scene.json`: `relcp run packing-{RODS}-scene.json --set time.dt=0.02`.\n\
         * Settings: ReLCP, overlap tolerance {tolerance:.0e}, the default solver. Made by `relcp study packing`.\n\
         * {}. Computed by {COMPUTED_BY}.\n\
         * CPU ms: the processor's time of all threads, where the system tells it; wall ms: the clock's, on a machine that may have been shared. Overlaps are true ones of the \
         smooth surfaces: at most after any step, and at the end computed afresh from the bodies alone.\n",
        0.5 * DIAMETER,
        machine(),
    );
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target::table(&study.targets()));
    ours(&mut out, runs);
    theirs(&mut out, runs);
    out
}

fn ours(out: &mut String, runs: &[Run]) {
    out.push_str(
        "\n## Ours\n\n| rods | dt | steps | CPU ms a step | wall ms a step | CPU s to the end | overlap, at most | overlap, at the end | radius of gyration | recursions a step | \
         products a step | rows, mean | rows, at the end |\n| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for Run { course, gyration } in runs {
        let steps = course.steps.max(1) as f64;
        let processor = course.cpu_milliseconds;
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {:.2} | {} | {:.1e} | {:.1e} | {} | {:.2} | {:.0} | {:.0} | {} |",
            course.bodies,
            course.dt,
            course.steps,
            processor.map_or("not told".into(), |all| format!("{:.2}", all / steps)),
            course.milliseconds / steps,
            processor.map_or("not told".into(), |all| format!("{:.1}", 1e-3 * all)),
            course.max_overlap,
            course.last_overlap,
            gyration.map_or(String::new(), |gyration| format!("{gyration:.4}")),
            course.recursions as f64 / steps,
            course.products as f64 / steps,
            course.constraints,
            course.last_constraints,
        );
    }
}

/// The engines' figures, and what ours are to them.
fn theirs(out: &mut String, runs: &[Run]) {
    let _ = write!(
        out,
        "\n## Public engines\n\nMeasured elsewhere, **on another machine**, one core, {RODS} rods, the same scene but for the draw of the orientations: times are to be compared by their order of magnitude only. None \
         of them is a dependency of this program. To run one: read the bodies of `packing-{RODS}-scene.json` (diameter and length of each rod, `position`, `orientation` as `[w, x, y, z]`) \
         into capsules; without gravity, friction and restitution; make it overdamped by giving each body the velocity that the field has at its centre before every step and no spin of \
         its own; step to time {END}; write the poses as a scene's `bodies` and let `relcp contacts` tell the overlaps, which are then told as ours are. In the last columns: the \
         engine's overlap over ours, and its time to advance by one unit over ours, of the run with {RODS} rods and the same step, else with the next larger one.\n\n\
         | engine | dt | ms a step | largest overlap | overlap over ours | time over ours |\n| --- | ---: | ---: | ---: | ---: | ---: |\n"
    );
    for engine in &ENGINES {
        let coarser = runs.iter().filter(|run| run.course.bodies == RODS && run.course.dt >= engine.dt);
        let own = coarser.min_by(|a, b| a.course.dt.total_cmp(&b.course.dt));
        let ratios = own.map_or("not run | not run".into(), |Run { course, .. }| {
            let time = engine.milliseconds / engine.dt / (course.step_milliseconds() / course.dt);
            format!("{:.0} | {time:.2} (ours at {})", engine.overlap / course.max_overlap, course.dt)
        });
        let _ = writeln!(
            out,
            "| {} | {} | {:.0} | {:.1e} | {ratios} |",
            engine.name, engine.dt, engine.milliseconds, engine.overlap
        );
    }
}

pub(super) fn targets(runs: &[Run]) -> Vec<Target> {
    let worst = |of: fn(&Run) -> f64| runs.iter().map(of).fold(0.0, f64::max);
    let held = |run: &Run| run.course.max_overlap.max(run.course.last_overlap) <= run.course.overlap_tolerance;
    let mut targets = vec![Target::new(
        "the overlap tolerance is held after every step at every dt, and at the end by an audit",
        format!("{:.3e} at most, {:.3e} at the end", worst(|r| r.course.max_overlap), worst(|r| r.course.last_overlap)),
        (!runs.is_empty()).then(|| runs.iter().all(held)),
    )];
    let of_engines: Vec<(f64, f64)> = runs
        .iter()
        .filter(|run| run.course.bodies == RODS)
        .filter_map(|run| Some((run.course.dt, run.gyration?)))
        .collect();
    let words: Vec<String> = of_engines
        .iter()
        .map(|(dt, gyration)| format!("{gyration:.4} ({:+.2}%) at {dt}", 100.0 * (gyration / GYRATION - 1.0)))
        .collect();
    targets.push(Target::new(
        format!("radius of gyration of {RODS} rods at the end {GYRATION} within {:.0}%", 100.0 * GYRATION_WITHIN),
        words.join(", "),
        (!of_engines.is_empty())
            .then(|| of_engines.iter().all(|(_, found)| (found / GYRATION - 1.0).abs() <= GYRATION_WITHIN)),
    ));
    let all: Vec<&Run> = runs.iter().filter(|run| run.course.bodies == RODS).collect();
    let least = ENGINES.iter().map(|engine| engine.overlap).fold(f64::INFINITY, f64::min);
    let most = all.iter().map(|run| run.course.max_overlap).fold(0.0, f64::max);
    targets.push(Target::new(
        format!("overlap of {RODS} rods at every dt under a tenth of the least of the engines'"),
        if all.is_empty() { String::new() } else { format!("{most:.1e} against {least:.1e}") },
        (!all.is_empty()).then_some(most < 0.1 * least),
    ));
    targets
}
