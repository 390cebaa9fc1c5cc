//! The page of the study.

use super::{ByGeneration, COUNTED_EVERY, CUTOFF_PER_THICKNESS, DT, Morphology, Row, SHOWN, Study, WIDTH};
use crate::machine::machine;
use crate::paper::{COMPUTED_BY, Target, order, target};
use std::fmt::Write as _;

/// Of the paper's Table 3: sub-spheres, rows over ReLCP's, microseconds a row; each with its standard deviation.
pub(super) const PAPER: [(Option<u32>, [f64; 2], [f64; 2]); 5] = [
    (None, [1.0, 0.0], [341.0, 1010.0]),
    (Some(5), [8.77, 2.47], [82.2, 251.0]),
    (Some(7), [17.0, 5.1], [45.9, 101.0]),
    (Some(17), [101.0, 32.8], [20.6, 30.8]),
    (Some(27), [252.0, 78.0], [15.3, 20.1]),
];

/// The rows over ReLCP's of that.
pub(super) const PAPER_ROWS: [(u32, f64); 4] = [(5, 8.77), (7, 17.0), (17, 101.0), (27, 252.0)];

/// Cells at the paper's end.
const PAPER_CELLS: u32 = 131_072;

/// Beyond this many standard errors a difference of means is not chance.
const SIGNIFICANT: f64 = 2.0;

fn of_paper(row: &Row) -> Option<[[f64; 2]; 2]> {
    PAPER.iter().find(|(count, ..)| *count == row.spheres).map(|(_, rows, time)| [*rows, *time])
}

pub(super) fn page(study: &Study) -> String {
    let rows = study.rows();
    let mut out = head(study, &rows);
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target::table(&study.targets()));
    statistics(&mut out, &rows);
    let states = format!("ReLCP's first colony every {COUNTED_EVERY} steps of its last whole generation");
    out.push_str(&study.census().page(&PAPER_ROWS, &states));
    generations(&mut out, &study.by_generation());
    aligned(&mut out, &study.morphology());
    let shown: Vec<String> =
        study.first_runs().map(|run| format!("![{}]({})", run.summary.method, run.picture_name())).collect();
    if !shown.is_empty() {
        let _ = write!(
            out,
            "\n## Pictures\n\nThe first run of each method at its end, coloured by orientation: {}.\n\n{}\n",
            rows.iter().map(|row| format!("{} with {} cells", row.method, row.bodies)).collect::<Vec<_>>().join(", "),
            shown.join("\n")
        );
    }
    out
}

fn head(study: &Study, rows: &[Row]) -> String {
    let tolerance = study.runs().first().map_or(0.0, |run| run.summary.overlap_tolerance);
    let most = rows.iter().map(|row| row.bodies).max().unwrap_or(0);
    let fewer: Vec<String> = rows
        .iter()
        .filter(|row| row.bodies < most)
        .map(|row| format!("{} was ended at {}", row.method, row.bodies))
        .collect();
    let fewer =
        if fewer.is_empty() { String::new() } else { format!(" {}, as more would take too long.", fewer.join(", ")) };
    let seeds: Vec<String> = study
        .size()
        .runs
        .iter()
        .filter(|runs| runs.seeds > 1)
        .map(|runs| format!("{} of {}", runs.seeds, runs.spheres.map_or("ReLCP".into(), |n| format!("LCP-MS {n}"))))
        .collect();
    let seeds = if seeds.is_empty() { "one".into() } else { format!("{}, one of the others", seeds.join(", ")) };
    format!(
        "# Colony\n\n\
         One cell grows into a colony: rows, time and alignment by ReLCP and by rows of sub-spheres (LCP-MS), the paper's Table 3 and Figure 5.\n\n\
         * Scene: the built-in `colony` (`relcp scenes colony`): planar, cells of diameter 0.5 that grow from length 2 to 4 at rate 1 and divide all together, each daughter turned by up to 0.01 degrees; \
         overdamped with drag 1; dt {DT}, to {most} cells (the paper: {PAPER_CELLS}; it tells no dt).{fewer} Runs: {seeds}; tables of rows and time are of seed 1.\n\
         * Settings: overlap tolerance {tolerance:.0e}, the default solver; rows of pairs nearer than {CUTOFF_PER_THICKNESS} diameters (`contact.cutoff`; the program's default is 0.1), which fits the paper's numbers of rows best of the distances tried (the table of rows by distance), \
         and of those that the free motion may bring into contact. Unconverged: solves that did not reach the solver's tolerance. Made by `cargo run --release -p relcp-lab -- colony`.\n\
         * {}. Computed by {COMPUTED_BY}. Times are the processor's, of all threads; the paper's are of 64 threads, another program and another solver.\n\
         * Rows: of the last LCP of a step. Means and standard deviations are over windows of {WIDTH} steps that have rows. Of a method that ended earlier, over the steps that it took.\n\
         * Sub-spheres lie equally spaced on the rod's axis: with fewer than {} there are gaps along a full-grown cell that another's end fits into; the overlaps below tell it.\n",
        machine(),
        // Spheres on a segment of 4 - 0.5, no farther apart than a diameter.
        ((4.0 - 0.5) / 0.5) as u32 + 1,
    )
}

fn statistics(out: &mut String, rows: &[Row]) {
    out.push_str(
        "\n## Rows and time\n\nPaper: its Table 3, and in parentheses our mean over the paper's.\n\n\
         | method | cells | rows over ReLCP's | paper | us a row | paper | time over ReLCP's, all steps | at the end | rows at the end | products a step | overlap | of spheres | steps over | unconverged |\n\
         | --- | ---: | ---: | --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let spread = |mean: Option<f64>, deviation: Option<f64>| match (mean, deviation) {
            (Some(mean), Some(deviation)) => format!("{mean:.2} ± {deviation:.2}"),
            _ => String::new(),
        };
        let paper = |at: usize, own: Option<f64>| match (of_paper(row).map(|paper| paper[at]), own) {
            (Some([mean, deviation]), Some(own)) => format!("{mean} ± {deviation} ({:.2})", own / mean),
            _ => String::new(),
        };
        let ratio = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.2}"));
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.0} | {:.1e} | {} | {} of {} | {} |",
            row.method,
            row.bodies,
            spread(row.relative_constraints, row.relative_constraints_deviation),
            paper(0, row.relative_constraints),
            spread(row.row_microseconds, row.row_microseconds_deviation),
            paper(1, row.row_microseconds),
            ratio(row.relative_time),
            ratio(row.relative_time_at_the_end),
            row.last_constraints,
            row.products,
            row.max_overlap,
            row.proxy_overlap.map_or(String::new(), |overlap| format!("{overlap:.1e}")),
            row.steps_over,
            row.steps,
            row.unconverged,
        );
    }
    let spheres: Vec<&Row> = rows.iter().filter(|row| row.spheres.is_some()).collect();
    let [first, .., last] = spheres[..] else { return };
    let counts = [first, last].map(|row| f64::from(row.spheres.unwrap_or(1)));
    let (Some(a), Some(b), Some([c, _]), Some([d, _])) =
        (first.relative_constraints, last.relative_constraints, of_paper(first), of_paper(last))
    else {
        return;
    };
    let said = |pair: [f64; 2]| order(counts, pair).map_or("none".into(), |power| format!("{power:.2}"));
    let _ = writeln!(
        out,
        "\nFrom {} to {} sub-spheres the rows over ReLCP's grow with their number to the power {}; in the paper to {}.",
        counts[0],
        counts[1],
        said([a, b]),
        said([c[0], d[0]])
    );
}

fn generations(out: &mut String, lines: &[ByGeneration]) {
    out.push_str(
        "\n## By generation\n\nAverages over the steps with so many cells.\n\n| cells | method | rows | over ReLCP's | ms a step | over ReLCP's |\n\
         | ---: | --- | ---: | ---: | ---: | ---: |\n",
    );
    let mut lines: Vec<&ByGeneration> = lines.iter().collect();
    lines.sort_by_key(|line| line.bodies);
    for line in lines {
        let ratio = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.2}"));
        let _ = writeln!(
            out,
            "| {} | {} | {:.1} | {} | {:.3} | {} |",
            line.bodies,
            line.method,
            line.constraints,
            ratio(line.relative_constraints),
            line.milliseconds,
            ratio(line.relative_time)
        );
    }
}

fn aligned(out: &mut String, morphology: &[Morphology]) {
    let _ = write!(
        out,
        "\n## How cells are aligned\n\nAfter each division, as `relcp measure` has it (`docs/measures.md`): correlation length, where the correlation of orientations has fallen to 1/e (in a small colony it may not fall so far, and there is none); nematic order of all cells \
         and of their neighbourhoods; cells of a microdomain. The paper shows pictures: \"extended regions of local alignment\" with {SHOWN} sub-spheres, \"smaller aligned groups\" by ReLCP. Means over the seeds ± standard \
         deviation where there are several; the difference in standard errors of the difference.\n\n\
         | quantity | cells | ReLCP | LCP-MS {SHOWN} | over ReLCP's | standard errors |\n| --- | ---: | ---: | ---: | ---: | ---: |\n"
    );
    for line in morphology {
        let spread = |mean: f64, deviation: Option<f64>| match deviation {
            Some(deviation) => format!("{mean:.3} ± {deviation:.3}"),
            None => format!("{mean:.3}"),
        };
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {:.2} | {} |",
            line.quantity,
            line.bodies,
            spread(line.relcp, line.relcp_deviation),
            spread(line.spheres, line.spheres_deviation),
            line.spheres / line.relcp,
            line.significance().map_or(String::new(), |errors| format!("{errors:.1}"))
        );
    }
}

pub(super) fn targets(study: &Study) -> Vec<Target> {
    let rows = study.rows();
    let relcp: Vec<_> = study.runs().iter().filter(|run| run.summary.is_relcp()).collect();
    let over: u64 = relcp.iter().map(|run| run.summary.steps_over).sum();
    let largest = relcp.iter().map(|run| run.summary.max_overlap).fold(0.0, f64::max);
    let own = rows.iter().find(|row| row.spheres.is_none()).and_then(|row| row.row_microseconds);
    let mut targets = vec![Target::new(
        "ReLCP holds the overlap tolerance after every step",
        format!("{largest:.3e} at most, {over} steps over"),
        (!relcp.is_empty()).then_some(over == 0),
    )];
    let spheres: Vec<&Row> = rows.iter().filter(|row| row.spheres.is_some()).collect();
    let least = |wanted: &str, of: &dyn Fn(&Row) -> Option<[f64; 2]>| {
        let found =
            spheres.iter().filter_map(|row| Some((format!("{} at {} cells", row.method, row.bodies), of(row)?)));
        Target::at_least(wanted, &found.collect::<Vec<_>>())
    };
    targets.push(least("LCP-MS has more rows than ReLCP, on average", &|row| Some([row.relative_constraints?, 1.0])));
    targets.push(least("LCP-MS has as many rows over ReLCP's as in the paper at least, on average", &|row| {
        Some([row.relative_constraints?, of_paper(row)?[0][0]])
    }));
    let near = |row: &&Row| Some((row.method.clone(), row.relative_constraints? / of_paper(row)?[0][0]));
    targets.push(Target::near("rows over ReLCP's, on average,", &spheres.iter().filter_map(near).collect::<Vec<_>>()));
    targets.push(study.census().target(&PAPER_ROWS));
    targets.push(least("LCP-MS takes more time a step than ReLCP at its end", &|row| {
        Some([row.relative_time_at_the_end?, 1.0])
    }));
    targets.push(least(
        "a row of ReLCP takes more time than one of LCP-MS, as in the paper: ReLCP's over the other's",
        &|row| Some([own? / row.row_microseconds?, 1.0]),
    ));
    targets.push(longer(&study.morphology()));
    targets
}

/// Whether orientations are correlated over longer distances with sub-spheres, in the largest colony that both have.
fn longer(morphology: &[Morphology]) -> Target {
    let last = morphology.iter().filter(|line| line.quantity == "correlation length").max_by_key(|line| line.bodies);
    let wanted = format!(
        "orientations are correlated over longer distances with {SHOWN} sub-spheres than by ReLCP, as in the paper"
    );
    let Some(line) = last else {
        return Target::new(wanted, "orientations stay correlated over the whole of colonies as small as these", None);
    };
    let chance = match line.significance() {
        Some(errors) if errors.abs() < SIGNIFICANT => format!("{errors:.1} standard errors, which may be chance"),
        Some(errors) => format!("{errors:.1} standard errors"),
        None => "one colony each, so it may be chance".into(),
    };
    let found = format!("{:.2} against {:.2} in colonies of {}; {chance}", line.spheres, line.relcp, line.bodies);
    // Of single colonies it is not known.
    Target::new(wanted, found, line.significance().map(|errors| errors >= SIGNIFICANT))
}
