//! The page: tables of all results.

use super::results::{Finding, Results};
use super::{Check, ClusterRow, Growth, IterationRow, SmallRow, SpeedRow};
use std::fmt::Write as _;

/// The allowed overlap of steps: the tolerance of the scenes.
pub(super) const OVERLAP: f64 = 1e-5;

/// Returns the finding of an item as one line.
pub(super) fn said(finding: &Finding) -> String {
    match finding {
        Finding::Parity { checks } => {
            let held = checks.iter().filter(|check| check.held).count();
            format!("{held} of {} within their bounds", checks.len())
        }
        Finding::Bandwidth { bytes_a_second } => format!("{:.2} GB/s", bytes_a_second / 1e9),
        Finding::Speed(row) => format!("{:.2} ms a step, {:.1} us an iteration", row.step_ms, row.iteration_us),
        Finding::Iteration { rows } => format!("{} stages", rows.len()),
        Finding::Small { rows } => format!("{} problems", rows.len()),
        Finding::Clusters(row) => format!("{:.1} us by pairs, {:.1} us by clusters", row.pairs_us, row.clusters_us),
        Finding::Growth(growth) => format!("to {} cells", growth.cells),
        Finding::Failed { why } => format!("failed: {why}"),
    }
}

/// Returns the whole page.
pub(super) fn page(results: &Results) -> String {
    let machine = &results.machine;
    let mut out = format!(
        "# {}\n\nDriver: {}. {}. Measured {}. Made by `cargo run --release -p relcp-lab -- device`; the same command goes on with what is \
         missing.\n\n| | |\n| --- | --- |\n",
        machine.adapter,
        machine.driver,
        results.host,
        dates(results)
    );
    for (name, value) in &results.device {
        let _ = writeln!(out, "| {name} | {value} |");
    }
    let bandwidth = results.finding("bandwidth");
    if let Some(Finding::Bandwidth { bytes_a_second }) = bandwidth {
        let _ = writeln!(out, "| copies, read and written | {:.2} GB/s |", bytes_a_second / 1e9);
    }
    parity(&mut out, results);
    speeds(&mut out, results);
    iterations(&mut out, results);
    small(&mut out, results);
    clusters(&mut out, results);
    growth(&mut out, results);
    missing(&mut out, results);
    out
}

fn found<'a, T>(results: &'a Results, of: impl Fn(&'a Finding) -> Option<T>) -> Vec<T> {
    results.items.values().filter_map(|entry| of(&entry.finding)).collect()
}

fn parity(out: &mut String, results: &Results) {
    let checks: Vec<&Check> = found(results, |finding| match finding {
        Finding::Parity { checks } => Some(checks),
        _ => None,
    })
    .into_iter()
    .flatten()
    .collect();
    if checks.is_empty() {
        return;
    }
    let held = checks.iter().filter(|check| check.held).count();
    let _ = write!(
        out,
        "\n## Against the CPU\n\n{held} of {} largest differences are within their bounds, those of docs/gpu.md. \
         Separations and points are parts of the sizes, blocks of J of the largest entry.\n\n\
         | what | precision | compared | largest | bound | |\n| --- | --- | ---: | ---: | ---: | --- |\n",
        checks.len()
    );
    for Check { what, precision, compared, largest, bound, held } in checks {
        let held = if *held { "held" } else { "**missed**" };
        let _ = writeln!(out, "| {what} | {precision} | {compared} | {largest:.1e} | {bound:.1e} | {held} |");
    }
}

pub(super) fn speed_rows(results: &Results) -> Vec<&SpeedRow> {
    let mut rows = found(results, |finding| match finding {
        Finding::Speed(row) => Some(&**row),
        _ => None,
    });
    rows.sort_by_key(|row| (row.kind.name(), row.precision.clone(), row.bodies));
    rows
}

fn speeds(out: &mut String, results: &Results) {
    let rows = speed_rows(results);
    if rows.is_empty() {
        return;
    }
    out.push_str(
        "\n## Whole steps\n\nCopies of stored states side by side, dt = 0.001, after steps in which kernels are compiled. \"of a copy\": \
         bytes that an iteration must move a second, over those that the device copies a second.\n\n\
         | what | bodies | precision | rows | ms a step | broad / narrow / solve / integrate / growth, ms | recursions | iterations | us an iteration | of a copy | dispatches | read-backs | worst overlap | unconverged |\n\
         | --- | ---: | --- | ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let stages: Vec<String> = row.stages_ms.iter().map(|ms| format!("{ms:.2}")).collect();
        let part = row.part_of_copy.map_or("-".into(), |part| format!("{:.1} %", 100.0 * part));
        let overlap = if row.max_overlap > OVERLAP { "**" } else { "" };
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {:.2} | {} | {:.2} | {:.0} | {:.1} | {part} | {:.0} | {:.1} | {overlap}{:.1e}{overlap} | {} |",
            row.kind.name(),
            row.bodies,
            row.precision,
            row.constraints,
            row.step_ms,
            stages.join(" / "),
            row.recursions,
            row.iterations,
            row.iteration_us,
            row.dispatches,
            row.reads,
            row.max_overlap,
            row.unconverged
        );
    }
}

fn iterations(out: &mut String, results: &Results) {
    let rows: Vec<&IterationRow> = found(results, |finding| match finding {
        Finding::Iteration { rows } => Some(rows),
        _ => None,
    })
    .into_iter()
    .flatten()
    .collect();
    if rows.is_empty() {
        return;
    }
    out.push_str(
        "\n## By stage\n\nFrom timestamps of every pass; a stage of the solver also by one of its iterations. The host waits where it reads.\n\n\
         | what | bodies | precision | stage | device ms a step | us an iteration | dispatches | read-backs | waited ms | bytes read | bytes written |\n\
         | --- | ---: | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let number = |number: Option<f64>| number.map_or("-".into(), |number| format!("{number:.3}"));
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {:.1} | {:.1} | {:.3} | {:.0} | {:.0} |",
            row.kind.name(),
            row.bodies,
            row.precision,
            row.stage,
            number(row.step_ms),
            number(row.iteration_us),
            row.dispatches,
            row.reads,
            row.wait_ms,
            row.bytes_read,
            row.bytes_written
        );
    }
}

fn small(out: &mut String, results: &Results) {
    let rows: Vec<&SmallRow> = found(results, |finding| match finding {
        Finding::Small { rows } => Some(rows),
        _ => None,
    })
    .into_iter()
    .flatten()
    .collect();
    if rows.is_empty() {
        return;
    }
    out.push_str(
        "\n## One workgroup or many\n\nAn iteration of parts of stored LCPs, solved by a single workgroup and by dispatches of all stages. The program takes one \
         workgroup up to a fixed number of rows, pairs and bodies.\n\n\
         | LCP | rows | precision | one workgroup, us | many, us | faster |\n| --- | ---: | --- | ---: | ---: | --- |\n",
    );
    for SmallRow { lcp, constraints, precision, one_workgroup_us: one, many_workgroups_us: many } in rows {
        let faster = if one < many { "one" } else { "many" };
        let _ = writeln!(out, "| {lcp} | {constraints} | {precision} | {one:.1} | {many:.1} | {faster} |");
    }
}

fn clusters(out: &mut String, results: &Results) {
    let mut rows: Vec<&ClusterRow> = found(results, |finding| match finding {
        Finding::Clusters(row) => Some(row),
        _ => None,
    });
    if rows.is_empty() {
        return;
    }
    rows.sort_by_key(|row| (row.precision.clone(), row.bodies));
    out.push_str(
        "\n## Pairs or clusters\n\nAn iteration of `pair_block_cg` and of `cluster_cg` on copies of a stored LCP of a colony, and what a solve \
         takes besides. In a crowded colony of 1,024 or 4,096 cells `cluster_cg` takes a quarter to a fifth of the iterations: it is faster where the \
         ratio is below 4.\n\n\
         | bodies | rows | precision | by pairs, us | by clusters, us | ratio | besides, ms | besides with clusters, ms |\n\
         | ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let ratio = row.clusters_us / row.pairs_us;
        let ClusterRow { bodies, constraints, precision, pairs_us: pairs, clusters_us: clusters, .. } = row;
        let besides = [row.pairs_set_up_ms, row.clusters_set_up_ms];
        let _ = writeln!(
            out,
            "| {bodies} | {constraints} | {precision} | {pairs:.1} | {clusters:.1} | {ratio:.1} | {:.2} | {:.2} |",
            besides[0], besides[1]
        );
    }
}

pub(super) fn growths(results: &Results) -> Vec<&Growth> {
    found(results, |finding| match finding {
        Finding::Growth(growth) => Some(growth),
        _ => None,
    })
}

fn growth(out: &mut String, results: &Results) {
    let growths = growths(results);
    if growths.is_empty() {
        return;
    }
    out.push_str("\n## A colony from one cell\n\n");
    for growth in &growths {
        let Growth { computed_by, dt, cells, whole, steps_by_cpu, .. } = growth;
        let end = if *whole { "all that was asked for" } else { "the time was over" };
        let _ = write!(out, "{computed_by}: dt = {dt}, to {cells} cells ({end})");
        let _ = if *steps_by_cpu > 0 {
            writeln!(out, "; {steps_by_cpu} steps left to the CPU.\n")
        } else {
            writeln!(out, ".\n")
        };
    }
    out.push_str(
        "| computed by | cells | steps | s from the start | iterations | rows | worst overlap |\n\
         | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for growth in &growths {
        for d in &growth.doublings {
            let _ = writeln!(
                out,
                "| {} | {} | {} | {:.2} | {} | {} | {:.1e} |",
                growth.computed_by, d.cells, d.steps, d.wall_seconds, d.iterations, d.constraints, d.max_overlap
            );
        }
    }
}

/// Writes the failed and the skipped items.
fn missing(out: &mut String, results: &Results) {
    let failed = results.items.iter().filter_map(|(name, entry)| match &entry.finding {
        Finding::Failed { why } => Some((name, why)),
        _ => None,
    });
    let failed: Vec<_> = failed.collect();
    if failed.is_empty() && results.skipped.is_empty() {
        out.push_str("\nNothing was left out.\n");
        return;
    }
    out.push_str("\n## Missing\n\n");
    for (name, why) in failed {
        let _ = writeln!(out, "* {name} failed: {why}");
    }
    for (name, why) in &results.skipped {
        let _ = writeln!(out, "* {name} was left out: {why}");
    }
}

/// Returns the first and the last day on which items ended.
fn dates(results: &Results) -> String {
    let times = || results.items.values().map(|entry| entry.ended_unix_seconds);
    match (times().min(), times().max()) {
        (Some(first), Some(last)) if date(first) == date(last) => format!("on {}", date(first)),
        (Some(first), Some(last)) => format!("from {} to {}", date(first), date(last)),
        _ => "not yet".into(),
    }
}

/// Returns the date of a time since 1970, in the Gregorian calendar (the algorithm of H. Hinnant, "chrono-compatible
/// low-level date algorithms").
pub(super) fn date(unix_seconds: u64) -> String {
    let days = (unix_seconds / 86_400) as i64 + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    format!("{year}-{month:02}-{day:02}")
}
