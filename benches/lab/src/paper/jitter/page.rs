//! The page of the study.

use super::run::PRESS;
use super::{Capsules, Method, Run, Study};
use crate::machine::machine;
use crate::paper::{COMPUTED_BY, Target, target};
use std::fmt::Write as _;

/// How many times more a method without recursion is to shake.
const TIMES: f64 = 10.0;

pub(super) fn page(study: &Study) -> String {
    let tolerance = study.runs().first().map_or(0.0, |run| run.overlap_tolerance);
    let mut out = format!(
        "# Jitter of three capsules\n\n\
         Three capsules that overlap at the start: the paper's toy problem (its Figure 2, a picture without figures). One row a pair (LCP-SNSD, `contact.method = \
         \"snsd\"`) leaves motion across the rows free, so that bodies overlap after the step and are thrown about in the next; ReLCP adds rows within the step until none \
         overlaps.\n\n\
         * Scene: the built-in `three-capsules` (`relcp scenes three-capsules`): diameter 0.25, length 1.25, overdamped with drag 1. Left alone there is no force, so how \
         far a step moves the bodies does not depend on `dt`: runs with different `dt` are the same, step by step (their figures tell it). Pressed together, the outer two are \
         pushed towards the middle one: `--set` {}.\n\
         * Settings: overlap tolerance {tolerance:.0e}, the default solver. {} steps left alone; pressed to time {}. Made by `cargo run --release -p relcp-lab -- jitter`.\n\
         * {}. Computed by {COMPUTED_BY}.\n\
         * Jitter is the root mean square, over the tips of the rods and over steps, of the second difference of their places from one step to the next, a length; \
         displacement is that of the first difference. Their ratio is 2 where each step undoes the last, and near zero in smooth motion. Late: in the \
         second half of the steps.\n",
        PRESS.map(|set| format!("`{set}`")).join(", "),
        study.size().steps_alone,
        study.size().end,
        machine(),
    );
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target::table(&study.targets()));
    for capsules in [Capsules::Alone, Capsules::Pressed] {
        write_runs(&mut out, study.runs(), capsules, tolerance);
    }
    out
}

fn write_runs(out: &mut String, runs: &[Run], capsules: Capsules, tolerance: f64) {
    let _ = write!(
        out,
        "\n## {}\n\n| method | dt | overlap after step 1 | late overlap | steps over {tolerance:.0e} | none over from step | late jitter | late displacement | ratio | \
         recursions | products |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
        match capsules {
            Capsules::Alone => "Left alone",
            Capsules::Pressed => "Pressed together",
        }
    );
    for run in runs.iter().filter(|run| run.case.capsules == capsules) {
        let resolved = run.resolved_at.map_or("never".into(), |step| step.to_string());
        let ratio = run.late.ratio().map_or("at rest".into(), |ratio| format!("{ratio:.3}"));
        let _ = writeln!(
            out,
            "| {} | {:.0e} | {:.2e} | {:.2e} | {} of {} | {resolved} | {:.2e} | {:.2e} | {ratio} | {} | {} |",
            run.case.method.name(),
            run.case.dt,
            run.first_overlap,
            run.late_overlap,
            run.steps_over,
            run.steps,
            run.late.jitter(),
            run.late.displacement(),
            run.recursions,
            run.products
        );
    }
}

pub(super) fn targets(runs: &[Run]) -> Vec<Target> {
    let of = |method: Method| runs.iter().filter(|run| run.case.method == method).collect::<Vec<&Run>>();
    let (relcp, snsd) = (of(Method::Relcp), of(Method::Snsd));
    let largest = |runs: &[&Run]| runs.iter().map(|run| run.max_overlap).fold(0.0, f64::max);
    let over = |runs: &[&Run]| runs.iter().map(|run| run.steps_over).sum::<u64>();
    let mut targets = vec![Target::new(
        "ReLCP holds the overlap tolerance after the first step and every other",
        format!("{:.1e} at most, {} steps over", largest(&relcp), over(&relcp)),
        (!relcp.is_empty()).then(|| over(&relcp) == 0),
    )];
    let pressed: Vec<&Run> = snsd.iter().copied().filter(|run| run.case.capsules == Capsules::Pressed).collect();
    let words: Vec<String> =
        pressed.iter().map(|run| format!("{} of {} at {:.0e}", run.steps_over, run.steps, run.case.dt)).collect();
    targets.push(Target::new(
        "LCP-SNSD, pressed, leaves more than the tolerance at every dt",
        words.join(", "),
        (!pressed.is_empty()).then(|| pressed.iter().all(|run| run.steps_over > 0)),
    ));
    let jitters: Vec<(f64, [f64; 2])> =
        pressed.iter().filter_map(|run| Some((run.case.dt, against(run, &relcp)?))).collect();
    let words: Vec<String> =
        jitters.iter().map(|(dt, [snsd, relcp])| format!("{snsd:.1e} against {relcp:.1e} at {dt:.0e}")).collect();
    targets.push(Target::new(
        format!("LCP-SNSD, pressed, shakes {TIMES} times as much as ReLCP at every dt, late"),
        words.join(", "),
        (!jitters.is_empty()).then(|| jitters.iter().all(|(_, [snsd, relcp])| *snsd > TIMES * relcp)),
    ));
    targets
}

/// A run's late jitter, and that of ReLCP at the same step.
fn against(run: &Run, relcp: &[&Run]) -> Option<[f64; 2]> {
    let same = relcp.iter().find(|other| (other.case.capsules, other.case.dt) == (run.case.capsules, run.case.dt))?;
    Some([run.late.jitter(), same.late.jitter()])
}
