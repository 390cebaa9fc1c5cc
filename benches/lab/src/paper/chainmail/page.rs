//! The page of the study.

use super::{MAJOR_RADIUS, MINOR_RADIUS, Run, SPHERES, Study};
use crate::machine::machine;
use crate::paper::{COMPUTED_BY, RunSummary, Target, method_name, target};
use relcp::scene::Method;
use std::fmt::Write as _;

/// The overlap of smooth rings that the paper tells of its sub-spheres, a part of the minor radius ("approximately
/// 60%").
const PAPER_SPHERES: f64 = 0.6;

/// That of one row a pair: "at times exceeds the minor radius".
const PAPER_SNSD: f64 = 1.0;

pub(super) fn page(study: &Study) -> String {
    let size = study.size();
    let tolerance = study.runs().first().map_or(0.0, |run| run.summary.overlap_tolerance);
    let mut out = format!(
        "# Chainmail\n\n\
         A sheet of interlaced rings is stretched until it is taut, by three contact methods: the largest violation over time, the paper's last example (its Figure 6).\n\n\
         * Scene: the built-in `chainmail` with {side} by {side} rings (`relcp scenes chainmail`): major radius {MAJOR_RADIUS}, minor radius {MINOR_RADIUS}, overdamped with drag {drag}, the field \
         `radial_outward`; steps of {} to time {}. Step and radii are the paper's; it tells neither the number of rings nor the drag nor the duration. Violations grow with what a body moves in a step: without recursion 12 by 12 rings \
         came to 22% of the minor radius with drag 1, which is why it is less here. Each ring is turned about its own axis by the golden angle more than the one before, which only sub-spheres feel.\n\
         * Settings: overlap tolerance {tolerance:.0e}, the default solver. `contact.method` is `\"relcp\"`, `\"snsd\"` (LCP-SNSD) and `{{\"multisphere\": {{\"count\": {SPHERES}}}}}` (LCP-MS {SPHERES}). Made by `cargo run --release -p relcp-lab -- chainmail`.\n\
         * {}. Computed by {COMPUTED_BY}. Times are the processor's, of all threads.\n\
         * Overlaps are true ones of the smooth rings; of sub-spheres also that between the spheres themselves, which is what LCP-MS constrains. Extent: the root mean square of the \
         centres along an axis, of which the sheet lies in x and y.\n",
        size.dt,
        size.end,
        machine(),
        side = size.side,
        drag = size.drag,
    );
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target::table(&study.targets()));
    runs(&mut out, study.runs());
    beside_paper(&mut out, study.runs());
    out
}

fn runs(out: &mut String, runs: &[Run]) {
    out.push_str(
        "\n## Runs\n\n| method | overlap, at most | of the minor radius | overlap, at the end | overlap of spheres | steps over | unconverged solves | rows a step | recursions a step | products a step | ms a step | \
         extent x, y at the start | at the end |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- | --- |\n",
    );
    for Run { summary, first, last, .. } in runs {
        let steps = summary.steps.max(1) as f64;
        let _ = writeln!(
            out,
            "| {} | {:.1e} | {:.1}% | {:.1e} | {} | {} of {} | {} | {:.0} | {:.2} | {:.0} | {:.2} | {:.3}, {:.3} | {:.3}, {:.3} |",
            summary.method,
            summary.max_overlap,
            100.0 * summary.max_overlap / MINOR_RADIUS,
            summary.last_overlap,
            summary.proxy_overlap.map_or(String::new(), |overlap| format!("{overlap:.1e}")),
            summary.steps_over,
            summary.steps,
            summary.unconverged,
            summary.constraints,
            summary.recursions as f64 / steps,
            summary.products as f64 / steps,
            summary.milliseconds / steps,
            first[0],
            first[1],
            last[0],
            last[1],
        );
    }
}

/// What the paper's text says of its figure, and what ours is to it.
fn beside_paper(out: &mut String, runs: &[Run]) {
    let part = |method: Method| of(runs, method).map(|summary| summary.max_overlap / MINOR_RADIUS);
    let said = |found: Option<f64>, paper: f64| match found {
        Some(found) => format!("{:.1}%: {:.2} times the paper's", 100.0 * found, found / paper),
        None => "not run".into(),
    };
    let spheres = Method::Multisphere { count: SPHERES };
    let proxy = of(runs, spheres).and_then(|summary| Some((summary.proxy_overlap?, summary.overlap_tolerance)));
    let relcp = of(runs, Method::Relcp).map(|summary| (summary.max_overlap, summary.overlap_tolerance));
    let held = |found: Option<(f64, f64)>| match found {
        Some((overlap, tolerance)) => format!("{overlap:.1e}: {:.2} times the tolerance", overlap / tolerance),
        None => "not run".into(),
    };
    let _ = write!(
        out,
        "\n## Beside the paper\n\nThe paper's figure has no table; what its text says of it.\n\n| largest violation | paper | ours |\n| --- | --- | --- |\n\
         | ReLCP, smooth rings | below 1e-5 | {} |\n| LCP-MS {SPHERES}, its spheres | below 1e-5 | {} |\n\
         | LCP-MS {SPHERES}, smooth rings | about {:.0}% of the minor radius | {} |\n| LCP-SNSD | at times over {:.0}% of the minor radius | {} |\n",
        held(relcp),
        held(proxy),
        100.0 * PAPER_SPHERES,
        said(part(spheres), PAPER_SPHERES),
        100.0 * PAPER_SNSD,
        said(part(Method::Snsd), PAPER_SNSD),
    );
    // Grooves between equal spheres on a circle: what two rings that lie in each other's grooves overlap by at most.
    let half = std::f64::consts::PI / f64::from(SPHERES);
    let chord = MAJOR_RADIUS * half.sin();
    let depth = MINOR_RADIUS - (MINOR_RADIUS * MINOR_RADIUS - chord * chord).max(0.0).sqrt();
    let _ = writeln!(
        out,
        "\nTwo neighbouring spheres of {SPHERES} on a ring meet {depth:.3} below its surface, so a sphere of another ring sinks in by less: by {:.3}, until it touches both. \
         That is {:.0}% of the minor radius. Rings that cross at right angles with a groove of each at a groove of the other overlap by {:.3}, {:.0}%: what the paper calls about 60%. It is the most that {SPHERES} \
         spheres leave, whatever the drag: the built-in sheet of rings that are not turned comes to 25% with a drag of 0.05, 0.1, 0.2, 0.4 and 1 alike (to time 4), and without recursion to 200, 94, 46, 23 and 9%. \
         So the drag is to be found by the line of LCP-SNSD, and the lattice by that of LCP-MS; the paper tells neither.",
        sinks_in(chord),
        100.0 * sinks_in(chord) / MINOR_RADIUS,
        sinks_in(chord.hypot(chord)),
        100.0 * sinks_in(chord.hypot(chord)) / MINOR_RADIUS,
    );
}

/// How far a tube of spheres sinks into another, where the centres of their next spheres are `chord` apart along the
/// tubes: half the distance of two spheres of a tube, where a sphere lies in a groove.
fn sinks_in(chord: f64) -> f64 {
    2.0 * MINOR_RADIUS - (4.0 * MINOR_RADIUS * MINOR_RADIUS - chord * chord).max(0.0).sqrt()
}

fn of(runs: &[Run], method: Method) -> Option<&RunSummary> {
    runs.iter().map(|run| &run.summary).find(|summary| summary.method == method_name(method))
}

pub(super) fn targets(runs: &[Run]) -> Vec<Target> {
    let spheres = of(runs, Method::Multisphere { count: SPHERES });
    let snsd = of(runs, Method::Snsd);
    let over = |summary: &RunSummary| format!("{:.3e} at most, {} steps over", summary.max_overlap, summary.steps_over);
    let relcp = of(runs, Method::Relcp);
    let proxy = spheres.and_then(|summary| Some((summary, summary.proxy_overlap?)));
    let part = |summary: &RunSummary| format!("{:.1}% of the minor radius", 100.0 * summary.max_overlap / MINOR_RADIUS);
    vec![
        Target::new(
            "ReLCP holds the overlap tolerance after every step",
            relcp.map_or(String::new(), over),
            relcp.map(|summary| summary.steps_over == 0),
        ),
        Target::new(
            format!("LCP-MS {SPHERES} holds it between its own spheres after every step"),
            proxy.map_or(String::new(), |(_, overlap)| format!("{overlap:.1e} at most")),
            proxy.map(|(summary, overlap)| overlap <= summary.overlap_tolerance),
        ),
        Target::new(
            format!("LCP-MS {SPHERES} does not hold it between the smooth rings"),
            spheres.map_or(String::new(), |summary| format!("{}, {}", over(summary), part(summary))),
            spheres.map(|summary| summary.steps_over > 0),
        ),
        Target::new(
            "LCP-SNSD does not hold it",
            snsd.map_or(String::new(), |summary| format!("{}, {}", over(summary), part(summary))),
            snsd.map(|summary| summary.steps_over > 0),
        ),
        Target::new(
            "LCP-SNSD at times leaves more than the minor radius, as in the paper",
            snsd.map_or(String::new(), part),
            snsd.map(|summary| summary.max_overlap > MINOR_RADIUS),
        ),
    ]
}
