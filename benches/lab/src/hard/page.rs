//! The page of the study.

use super::{Measure, Row, Study, Verdict};
use crate::machine::machine;
use std::fmt::Write as _;

pub(super) fn page(study: &Study) -> String {
    let rows = study.rows();
    let count = |verdict: Verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let mut out = format!(
        "# Hard cases\n\n\
         Small scenes of the kinds that break contact codes, by the default method (ReLCP, the default solver) with the overlap tolerance 1e-5 of lengths of about 1, unless a \
         row says otherwise. After every step the overlaps of bodies with each other and with walls are computed afresh from the accepted bodies alone; nothing that the step knows is used.\n\n\
         * **holds**: at every step the overlap is at most the tolerance, and every solve reached its own.\n\
         * **reported**: not so, and the program itself says it: by the step's overlap or the solve's status, by naming bodies that went through each other, by refusing the scene, or by a typed error.\n\
         * **fails**: an accepted step is over the tolerance although the run was to stop there, a state is not finite, a panic, more overlap than the step reports, a solve that claims a tolerance that it missed, or what is measured beside contact \
         is over its bound.\n\n\
         {} cases: {} hold, {} are reported, {} fail.{} Made by `cargo run --release -p relcp-lab -- hard`. {}. Computed by CPU f64.\n",
        rows.len(),
        count(Verdict::Holds),
        count(Verdict::Reported),
        count(Verdict::Fails),
        if study.size().most_steps == u64::MAX {
            String::new()
        } else {
            format!(" At most {} steps a case.", study.size().most_steps)
        },
        machine(),
    );
    for group in rows.chunk_by(|a, b| a.group == b.group) {
        write_group(&mut out, group);
    }
    write_limits(&mut out, rows);
    out
}

fn write_group(out: &mut String, rows: &[Row]) {
    let Some(first) = rows.first() else { return };
    let _ = write!(
        out,
        "\n## {}\n\n| case | bodies | steps | largest overlap | recursions, mean | most | products | worst residual | unconverged | ended as | measured | verdict |\n\
         | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- | --- | --- |\n",
        title(first.group)
    );
    for row in rows {
        let figures = &row.figures;
        let _ = writeln!(
            out,
            "| {} | {} | {} | {:.1e} | {:.2} | {} | {} | {:.1e} | {} | {} | {} | {} |",
            row.case,
            figures.bodies,
            figures.steps,
            figures.max_overlap,
            figures.recursions_mean,
            figures.recursions_max,
            figures.products,
            figures.worst_residual,
            figures.unconverged,
            figures.ended(),
            row.measure.as_ref().map_or(String::new(), measured),
            row.verdict.name()
        );
    }
}

fn title(group: &str) -> String {
    let mut letters = group.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn measured(measure: &Measure) -> String {
    let Measure { what, value, bound, .. } = measure;
    if *bound == 0.0 { format!("{what}: {value}") } else { format!("{what}: {value:.1e} (at most {bound:.0e})") }
}

/// Writes every case that does not pass, with its reasons.
fn write_limits(out: &mut String, rows: &[Row]) {
    out.push_str("\n## Limitations\n\n");
    for (verdict, heading) in [(Verdict::Fails, "Fails"), (Verdict::Reported, "Reported by the program")] {
        let lines: Vec<&Row> = rows.iter().filter(|row| row.verdict == verdict).collect();
        if lines.is_empty() {
            let _ = writeln!(out, "* {heading}: none.");
        }
        for row in lines {
            let _ = writeln!(out, "* {heading}: {}: {}.", row.case, row.why.join("; "));
        }
    }
}
