//! The page of the study.

use super::{CUTOFF_PER_THICKNESS, Part, Row, Size, Study};
use crate::machine::machine;
use crate::paper::{COMPUTED_BY, order, target};
use relcp::scene::SolverKind;
use std::fmt::Write as _;

/// Of the paper's Table 2: step, sub-spheres, rows at the end, and the time over that of ReLCP.
pub(super) const PAPER: [(f64, u32, f64, f64); 10] = [
    (0.01, 23, 3.0e6, 215.0),
    (0.01, 17, 1.7e6, 67.0),
    (0.01, 13, 9.9e5, 39.0),
    (0.01, 7, 2.7e5, 7.0),
    (0.01, 3, 5.8e4, 0.8),
    (0.1, 23, 3.5e6, 642.0),
    (0.1, 17, 1.8e6, 402.0),
    (0.1, 13, 1.0e6, 174.0),
    (0.1, 7, 2.8e5, 28.0),
    (0.1, 3, 5.9e4, 1.9),
];

/// Rows over ReLCP's of that at 0.1, but for 3 sub-spheres: their ball goes on shrinking until they touch, so ReLCP's
/// dense state does not show it.
pub(super) const PAPER_ROWS: [(u32, f64); 4] =
    [(7, 2.8e5 / 2.9e4), (13, 1e6 / 2.9e4), (17, 1.8e6 / 2.9e4), (23, 3.5e6 / 2.9e4)];

/// Rows of ReLCP at the end, at both steps.
const PAPER_RELCP: f64 = 2.9e4;

/// Bodies there.
const PAPER_BODIES: f64 = 1e4;

/// The paper's step at which "the initial SNSD-LCP solve was accepted without further augmentation".
pub(super) const PAPER_LINEAR_DT: f64 = 0.01;

/// Rows and time over those of ReLCP in the paper.
pub(super) fn of_paper(row: &Row) -> Option<[f64; 2]> {
    let same = |(dt, count, ..): &&(f64, u32, f64, f64)| *dt == row.dt && Some(*count) == row.spheres;
    PAPER.iter().find(same).map(|(_, _, rows, time)| [rows / PAPER_RELCP, *time])
}

pub(super) fn page(study: &Study) -> String {
    let (rows, size) = (study.rows(), study.size());
    let mut out = head(study);
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target::table(&study.targets()));
    for (dt, counts) in size.steps {
        let of = |part: Part| -> Vec<&Row> { rows.iter().filter(|row| row.dt == *dt && row.part == part).collect() };
        if !of(Part::Whole).is_empty() {
            whole(&mut out, &of(Part::Whole), size, (*dt, counts));
        }
        if !of(Part::Dense).is_empty() {
            dense(&mut out, &of(Part::Dense), size, *dt);
        }
        if !of(Part::Public).is_empty() {
            public(&mut out, &of(Part::Public), *dt);
        }
    }
    out.push_str(&study.census.page(&PAPER_ROWS, "the dense state that ReLCP came to"));
    out
}

fn whole(out: &mut String, rows: &[&Row], size: &Size, (dt, counts): (f64, &[u32])) {
    let left_out: Vec<String> = size.dense.iter().filter(|count| !counts.contains(count)).map(u32::to_string).collect();
    let shorter = match left_out[..] {
        [] => String::new(),
        _ => format!(
            " With {} sub-spheres whole runs would take too long; they are below, from the dense state.",
            left_out.join(", ")
        ),
    };
    let _ = write!(
        out,
        "\n## dt {dt}, whole runs\n\nTo time {}. Rows and ms a step are averages of the last hundredth of the steps.{shorter}\n\n",
        size.end
    );
    table(out, rows);
}

fn dense(out: &mut String, rows: &[&Row], size: &Size, dt: f64) {
    let _ = write!(
        out,
        "\n## dt {dt}, from the dense state\n\nTime {} from the state that ReLCP came to, by every method without what earlier steps leave to start from. In the first half \
         sub-spheres come into contact with each other; rows and ms a step are averages of the second. Few sub-spheres are so much smaller than the ellipsoid that the ball goes on shrinking (its radius of \
         gyration tells); where there is a whole run, that is the one to go by.\n\n",
        size.dense_time
    );
    table(out, rows);
    growth(out, rows, dt);
}

fn public(out: &mut String, rows: &[&Row], dt: f64) {
    let _ = write!(
        out,
        "\n## dt {dt}, from the dense state, by the solver of public codes\n\nThe same steps with `solver.kind` {}. Ratios are over ReLCP's by the default solver, above.\n\n",
        solver_of_public_codes()
    );
    table(out, rows);
}

/// Its name in a scene.
fn solver_of_public_codes() -> String {
    let own = SolverKind::NAMED.into_iter().find(|(_, kind)| *kind == super::OF_PUBLIC_CODES);
    own.map_or(String::new(), |(name, _)| format!("`{name}`"))
}

fn head(study: &Study) -> String {
    let size = study.size();
    let tolerance = study.runs().first().map_or(0.0, |run| run.summary.overlap_tolerance);
    format!(
        "# Compaction\n\n\
         Ellipsoids are drawn from a dilute suspension into a dense ball: rows and time of ReLCP and of sub-spheres (LCP-MS), the paper's Table 2 and Figure 4.\n\n\
         * Scene: the built-in `compaction` (`relcp scenes compaction`) with {} ellipsoids of radii 1, 1, 2 (the paper has {PAPER_BODIES:.0}) at {}% volume fraction (the paper 0.25%), seed 1; overdamped with drag 1, the \
         field `radial_inward`. The paper gives neither drag nor duration, nor the distance within which it makes rows; here that is {CUTOFF_PER_THICKNESS} of a body's thickness \
         (`contact.cutoff`; the program's default is 0.1), which fits its numbers of rows (the last table), beside pairs that the free motion may bring into contact.\n\
         * Settings: overlap tolerance {tolerance:.0e}, the default solver. Made by `cargo run --release -p relcp-lab -- compaction`.\n\
         * {}. Computed by {COMPUTED_BY}. Times are the processor's, of all threads; the paper's are of 64 threads, another program and another solver.\n\
         * Rows: of the last LCP of a step. Ratios are over ReLCP's. Paper: rows and time over ReLCP's in its Table 2, and in parentheses ours over the paper's. Overlaps are true ones of the smooth surfaces, and of the \
         sub-spheres. Unconverged: solves that did not reach the solver's tolerance.\n",
        size.bodies,
        100.0 * size.volume_fraction,
        machine(),
    )
}

fn table(out: &mut String, rows: &[&Row]) {
    out.push_str(
        "| method | rows | over ReLCP | paper | ms a step | over ReLCP | paper | all steps over ReLCP | products a step | recursions | unconverged | overlap | of spheres | radius of gyration |\n\
         | --- | ---: | ---: | --- | ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.2}"));
        let paper = |at: usize, own: Option<f64>| match (of_paper(row), own) {
            (Some(paper), Some(own)) => format!("{:.1} ({:.2})", paper[at], own / paper[at]),
            _ => String::new(),
        };
        let _ = writeln!(
            out,
            "| {} | {:.0} | {} | {} | {:.2} | {} | {} | {} | {:.0} | {} | {} | {:.1e} | {} | {} |",
            row.method,
            row.constraints,
            number(row.relative_constraints),
            paper(0, row.relative_constraints),
            row.milliseconds,
            number(row.relative_time),
            paper(1, row.relative_time),
            number(row.relative_time_of_all),
            row.products,
            row.recursions,
            row.unconverged,
            row.max_overlap,
            row.proxy_overlap.map_or(String::new(), |overlap| format!("{overlap:.1e}")),
            row.gyration.map_or(String::new(), |gyration| format!("{gyration:.4}")),
        );
    }
}

/// How rows and time grow with the sub-spheres, here and in the paper.
fn growth(out: &mut String, rows: &[&Row], dt: f64) {
    let spheres: Vec<&&Row> = rows.iter().filter(|row| row.spheres.is_some()).collect();
    let [first, .., last] = spheres[..] else { return };
    let counts = [first, last].map(|row| f64::from(row.spheres.unwrap_or(1)));
    let (Some([a, c]), Some([b, d])) = (of_paper(first), of_paper(last)) else { return };
    let said = |pair: [f64; 2]| order(counts, pair).map_or("none".into(), |power| format!("{power:.2}"));
    let relcp = rows.iter().find(|row| row.spheres.is_none()).map_or(0.0, |row| row.constraints);
    let bodies = spheres_bodies(relcp);
    let _ = writeln!(
        out,
        "\nFrom {} to {} sub-spheres rows grow with their number to the power {} and time a step to {}; at dt {dt} of the paper to {} and {}.{bodies}",
        counts[0],
        counts[1],
        said([first.constraints, last.constraints]),
        said([first.milliseconds, last.milliseconds]),
        said([a, b]),
        said([c, d]),
    );
}

fn spheres_bodies(relcp: f64) -> String {
    format!(" ReLCP has {relcp:.0} rows at the end; the paper's {:.2} a body.", PAPER_RELCP / PAPER_BODIES)
}
