//! The page of the study.

use super::best::{Cheapest, Cost, Curve, ERRORS, curves};
use super::case::{OVERLAP_TOLERANCE, Row, Sweep};
use super::problem::Problem;
use super::reference::{CERTAINTY, Making, Reference};
use super::{Best, Study};
use crate::machine::machine;
use crate::paper::{Target, target_table};
use relcp::scene::Stepping;
use std::fmt::Write as _;

/// The error at which the two schemes are compared.
const COMPARED_AT: f64 = 1e-3;

pub(super) fn page(study: &Study) -> String {
    let mut out = head(study);
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target_table(&study.targets()));
    cheapest(&mut out, &study.best());
    for (problem, reference) in study.problems() {
        let rows = study.of(problem);
        scene(&mut out, problem, reference);
        costs(&mut out, reference, &rows);
        runs(&mut out, &rows);
    }
    out
}

fn head(study: &Study) -> String {
    let mut devices: Vec<String> = Vec::new();
    for row in study.rows() {
        let name = format!("{} ({})", row.computed_by, row.machine);
        if !devices.contains(&name) {
            devices.push(name);
        }
    }
    let software = match study.rows().iter().any(|row| row.computed_by.contains("software")) {
        true => " A software adapter computes on the processor: its times tell nothing of a GPU's.",
        false => "",
    };
    format!(
        "# Work and precision\n\n\
         What an error at the end of a run costs, in wall time and in products with `A`, by stepping scheme, contact method, step and overlap tolerance, on small scenes whose ends are known.\n\n\
         * Made by `cargo run --release -p relcp-lab -- work-precision`. {}. Computed by: {}.{software} Times are of this machine in this run, which it may have shared; of short runs the shortest of some.\n\
         * An error is the larger of two root mean squares over the bodies at the end: of the distances of the centres to the reference's, over the length of the scene's longest body at the start, and of the \
         angles between the long (or ring) axes, in radians. A spin about the axis is not seen, as the surface does not change either.\n\
         * References are stored in `assets/references` and made by `cargo run --release -p relcp-lab -- work-precision --make-references DIR`: the end of a fine midpoint run. The paper's step at two sizes, extrapolated to zero, is another \
         scheme's word on the same end, and the distance of the two is the reference's own error, as estimated. An error below {CERTAINTY} times that is marked by `~`: it may be the reference's.\n\
         * Curves: steps are halved at an overlap tolerance of {OVERLAP_TOLERANCE:.0e} (\"ReLCP\", \"LCP-SNSD\", \"LCP-MS\"); or steps and tolerance are refined together, at the rate at which the scheme's error falls (\"tolerance with \
         dt\": from 1e-3, a quarter for each halved midpoint step and for each quartered Euler step); or the tolerance alone at one step. Not the full product of them. LCPs are solved to a tenth of the \
         overlap tolerance by the default solver.\n\
         * What is not measured: what a device does not do, and tolerances under 1e-5 in f32 numbers. LCP-SNSD and LCP-MS do not hold an overlap tolerance; their overlap \
         stands beside their errors.\n",
        machine(),
        if devices.is_empty() { "nothing yet".into() } else { devices.join("; ") },
    )
}

fn said(cost: Cost, in_words: impl Fn(f64) -> String) -> String {
    let bound = if cost.at_most { "at most " } else { "" };
    format!("{bound}{}", in_words(cost.value))
}

fn milliseconds(seconds: f64) -> String {
    // Three digits, because times are not more accurate.
    let value = 1e3 * seconds;
    let decimals = (2.0 - (value * (1.0 + 1e-9)).log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{value:.decimals$} ms")
}

fn products(count: f64) -> String {
    format!("{count:.0}")
}

/// The cheapest ways, of all scenes.
fn cheapest(out: &mut String, best: &[Best]) {
    out.push_str(
        "\n## The cheapest way to an error\n\nAlong straight lines in logarithms between the runs of a curve, from where on all its finer runs are within the error. Where nothing is told, no curve gets there. \
         \"At most\": the coarsest run of the curve is more exact already. \
         \"Overlap\": the largest of the smooth surfaces in the curve's runs that are within the error.\n\n\
         | scene | error | by wall time | ms | overlap | by products | products | overlap |\n| --- | ---: | --- | ---: | ---: | --- | ---: | ---: |\n",
    );
    let words = |found: &Option<Cheapest>, of: fn(f64) -> String| match found {
        Some(Cheapest { curve, cost, max_overlap }) => format!("{curve} | {} | {max_overlap:.1e}", said(*cost, of)),
        None => " |  | ".into(),
    };
    for Best { problem, error, certain, by_wall, by_products } in best {
        let unsure = if *certain { "" } else { "~" };
        let (wall, products) = (words(by_wall, milliseconds), words(by_products, products));
        let _ = writeln!(out, "| {problem} | {unsure}{error:.0e} | {wall} | {products} |");
    }
}

fn scene(out: &mut String, problem: &Problem, reference: &Reference) {
    let Reference { made, estimate, length, unconverged, bodies, .. } = reference;
    let Making { midpoint_steps, midpoint_tolerance, euler_steps, euler_tolerance, solver_tolerance } = made;
    let sets: Vec<String> = problem.sets.iter().map(|set| format!("`{set}`")).collect();
    let sets = if sets.is_empty() { String::new() } else { format!(" with {}", sets.join(", ")) };
    let stalled = if *unconverged > 0 { format!(" {unconverged} solves did not converge.") } else { String::new() };
    let _ = write!(
        out,
        "\n## {}\n\n{}\n\n* Scene: the built-in `{}`{sets}; to time {}, {} bodies at the end; lengths over {length}.\n\
         * Reference: {midpoint_steps} midpoint steps at overlap tolerance {midpoint_tolerance:.0e}; {euler_steps} and {} of the paper's at {euler_tolerance:.0e}, extrapolated; residual {solver_tolerance:.0e}. They are {:.1e} apart in \
         position and {:.1e} in angle.{stalled}\n",
        problem.name,
        problem.about,
        problem.scene,
        problem.end,
        bodies.len(),
        2 * euler_steps,
        estimate.position,
        estimate.angle,
    );
}

/// Writes the cost of each curve.
fn costs(out: &mut String, reference: &Reference, rows: &[&Row]) {
    let curves: Vec<Curve> = curves(rows.iter().copied()).into_iter().filter(Curve::refines).collect();
    if curves.is_empty() {
        return;
    }
    let unsure = |error: f64| if reference.settles(error) { "" } else { "~" };
    let errors = ERRORS.map(|error| format!("{}{error:.0e}", unsure(error))).join(" | ");
    let _ = write!(
        out,
        "\nMilliseconds and products for an error of\n\n| curve | {errors} |\n| --- | ---: | ---: | ---: | ---: |\n"
    );
    for curve in curves {
        let cells = ERRORS.map(|error| {
            let wall = curve.cost(error, |row| row.wall_seconds).map(|cost| said(cost, milliseconds));
            let of_products = curve.cost(error, |row| row.products as f64).map(|cost| products(cost.value));
            match (wall, of_products) {
                (Some(wall), Some(products)) => format!("{wall}, {products}"),
                _ => String::new(),
            }
        });
        let _ = writeln!(out, "| {} | {} |", curve.name, cells.join(" | "));
    }
}

fn runs(out: &mut String, rows: &[&Row]) {
    out.push_str(
        "\n| run | computed by | steps | tolerance | error | order | position | angle | overlap | products | iterations | recursions | rows a step | ms | unconverged |\n\
         | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let number = |error: Option<f64>| error.map_or("other bodies".into(), |error| format!("{error:.2e}"));
        let unsure = if row.certain { "" } else { "~" };
        let order = row.order.map_or(String::new(), |order| format!("{order:.2}"));
        let _ = writeln!(
            out,
            "| {} | {} | {} | {:.1e} | {unsure}{} | {order} | {} | {} | {:.1e} | {} | {} | {} | {:.1} | {:.2} | {} |",
            row.curve,
            row.computed_by,
            row.steps,
            row.overlap_tolerance,
            number(row.error),
            number(row.position_error),
            number(row.angle_error),
            row.max_overlap,
            row.products,
            row.iterations,
            row.recursions,
            row.constraints,
            1e3 * row.wall_seconds,
            row.unconverged
        );
    }
}

pub(super) fn targets(study: &Study) -> Vec<Target> {
    let mut targets = vec![references(study), held(study)];
    targets.extend(study.problems().iter().map(|(problem, _)| cheaper(problem, &study.of(problem))));
    targets
}

fn references(study: &Study) -> Target {
    let estimates = study.problems().iter().map(|(problem, reference)| (problem.name, reference.estimate.worst()));
    let words: Vec<String> = estimates.clone().map(|(name, error)| format!("{error:.1e} ({name})")).collect();
    let bound = COMPARED_AT / 10.0;
    let met = estimates.clone().all(|(_, error)| error <= bound);
    Target::new(format!("two schemes agree on each reference to {bound:.0e}"), words.join(", "), Some(met))
}

fn held(study: &Study) -> Target {
    let missed: Vec<&Row> = study.rows().iter().filter(|row| row.missed()).collect();
    let of = study.rows().len();
    let found = match missed.first() {
        Some(row) => {
            format!("{} of {of} do not, the first {}, {}, {} steps", missed.len(), row.problem, row.curve, row.steps)
        }
        None => format!("all of {of}"),
    };
    let wanted = "every run of ReLCP holds its overlap tolerance at every step, and every solve its own";
    Target::new(wanted, found, (of > 0).then_some(missed.is_empty()))
}

/// Whether the best curve of midpoint steps costs less than the best of the paper's, on the CPU.
fn cheaper(problem: &Problem, rows: &[&Row]) -> Target {
    let wanted =
        format!("{}: midpoint steps take less time than the paper's for an error of {COMPARED_AT:.0e}", problem.name);
    let cost = |stepping: Stepping| {
        let of = |row: &&Row| {
            let relcp = row.method == "ReLCP" && row.sweep != Sweep::Tolerance;
            relcp && row.stepping == stepping && row.computed_by.starts_with("CPU")
        };
        let curves = curves(rows.iter().copied().filter(of));
        let costs = curves.iter().filter_map(|curve| curve.cost(COMPARED_AT, |row| row.wall_seconds));
        costs.min_by(|a, b| a.value.total_cmp(&b.value))
    };
    match (cost(Stepping::Euler), cost(Stepping::Midpoint)) {
        (Some(euler), Some(midpoint)) => Target::new(
            wanted,
            format!(
                "{:.2} times less: {} against {}",
                euler.value / midpoint.value,
                said(euler, milliseconds),
                said(midpoint, milliseconds)
            ),
            Some(midpoint.value < euler.value),
        ),
        (None, Some(midpoint)) => {
            let found = format!("the paper's do not get there; midpoint takes {}", said(midpoint, milliseconds));
            Target::new(wanted, found, Some(true))
        }
        (Some(euler), None) => {
            let found = format!("midpoint does not get there; the paper's take {}", said(euler, milliseconds));
            Target::new(wanted, found, Some(false))
        }
        (None, None) => Target::new(wanted, "neither gets there", None),
    }
}
