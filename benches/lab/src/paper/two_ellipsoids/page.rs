//! The page of the study.

use super::targets::{of, of_paper};
use super::{Row, Scheme, Side, Study};
use crate::machine::machine;
use crate::paper::{COMPUTED_BY, target};
use std::fmt::Write as _;

pub(super) fn page(study: &Study) -> String {
    let rows = study.rows();
    let mut out = head(study);
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target::table(&study.targets()));
    for side in [Side::Left, Side::Right] {
        refined(&mut out, study, &rows, side);
    }
    midpoint(&mut out, &of(&rows, Side::Right, Scheme::Midpoint));
    work(&mut out, &rows);
    out
}

/// The paper's two refinements, with the upper body to one side.
fn refined(out: &mut String, study: &Study, rows: &[Row], side: Side) {
    let of = |scheme| of(rows, side, scheme);
    let title = |of: &str| format!("{of}, upper body to the {}", side.name());
    let about_euler = "Steps of the paper's scheme. Against the reference, and in the paper's manner against the finest of these runs; the paper's own \
        figures last. Error of the paper at its finest step is zero as it is the reference there.";
    with_paper(out, &title("ReLCP, refined in time"), about_euler, &of(Scheme::Euler), |row| format!("{:.0e}", row.dt));
    let fine = of(Scheme::Euler).into_iter().find(|row| row.dt == study.size().multisphere_dt);
    let own = fine.map_or(String::new(), |row| format!(" ReLCP errs {:.1e} at that step.", row.worst));
    let about = format!(
        "Rows of sub-spheres on the long axis, inside the surface and tangent to it; how the paper spaces them is not stated there, here all grooves are equally deep. Steps of {:.0e} (the paper's are 1e-5; with {} spheres that would take {:.0} minutes here).{own}",
        study.size().multisphere_dt,
        study.size().spheres.last().copied().unwrap_or_default(),
        at_paper_step(&of(Scheme::Multisphere))
    );
    let spheres = of(Scheme::Multisphere);
    with_paper(out, &title("LCP-MS, refined in shape"), &about, &spheres, |row| {
        row.spheres.unwrap_or_default().to_string()
    });
}

/// Minutes that the last run would take at the paper's step.
fn at_paper_step(rows: &[&Row]) -> f64 {
    rows.last().map_or(0.0, |row| row.milliseconds / 6e4 * row.dt / 1e-5)
}

fn head(study: &Study) -> String {
    let reference = study.reference(Side::Right);
    let [x, y, angle] = [0, 1, 2].map(|i| study.references().iter().map(|of| of.difference[i]).fold(0.0, f64::max));
    format!(
        "# Two ellipsoids\n\n\
         Two identical ellipsoids are pushed together, slide and turn past each other: the paper's refinement study (its Table 1 and Figure 3), and the midpoint step \
         beside it.\n\n\
         * Scene: the built-in `two-ellipsoids` (`relcp scenes two-ellipsoids`). Radii 1, 1, 2; long axes at 45 degrees in the x-y plane; centres apart by (1, 5); unit \
         forces along -y and +y; overdamped with drag 1; to time 40. The paper gives neither drag nor gap, and its figure has the passage from time 100 to 400, here 4 to \
         37.7: steps of the same number need not be equally fine there and here.\n\
         * Sides: the long axes point to the upper right, and in the built-in scene the upper body is to the right: the bodies turn until they lie flat on each other, nearly balanced, and what decides how long they stay is small. \
         To the left they slip past each other. The paper says that centres are \"offset by a unit distance along x\" and not to which side; refinements are made with both. Midpoint steps are of the built-in scene.\n\
         * Settings: overlap tolerance {:.0e} as in the paper, residual {:.0e}, the default solver. Made by `cargo run --release -p relcp-lab -- two-ellipsoids`.\n\
         * {}. Computed by {COMPUTED_BY}. Times are of this machine in this run, which it may have shared; of short runs the shortest of some.\n\
         * An error is `sqrt(integral of (x - reference)^2 dt)` over the run, of the upper body's x and y and of the angle of its long axis in radians. The paper says \
         \"L2 norms\" and no more. In the CSV are also the errors over the norm of the reference.\n\
         * The references, one a side: midpoint steps of {} at overlap tolerance {:.0e} and residual {:.0e}. The paper's steps of {} and {} at that residual, extrapolated to zero, are at most {x:.1e}, {y:.1e} and {angle:.1e} \
         away in x, y and angle.\n",
        reference.overlap_tolerance,
        reference.solver_tolerance,
        machine(),
        reference.midpoint_dt,
        reference.tight_overlap_tolerance,
        reference.tight_solver_tolerance,
        reference.euler_dt,
        0.5 * reference.euler_dt,
    )
}

fn with_paper(out: &mut String, title: &str, about: &str, rows: &[&Row], name: impl Fn(&Row) -> String) {
    if rows.is_empty() {
        return;
    }
    let first = if rows[0].spheres.is_some() { "spheres" } else { "dt" };
    let _ = write!(
        out,
        "\n## {title}\n\n{about}\n\n| {first} | x | y | angle | order | x, y, angle against the finest ReLCP | paper's x, y, angle |\n\
         | ---: | ---: | ---: | ---: | ---: | --- | --- |\n"
    );
    for row in rows {
        let order = row.order.map_or(String::new(), |order| format!("{order:.2}"));
        let to_finest = match (row.x_to_finest, row.y_to_finest, row.angle_to_finest) {
            (Some(x), Some(y), Some(angle)) => format!("{x:.4}, {y:.4}, {angle:.4}"),
            _ => String::new(),
        };
        let paper = of_paper(row).map_or(String::new(), |[x, y, angle]| format!("{x:.4}, {y:.4}, {angle:.4}"));
        let Row { x, y, angle, .. } = row;
        let _ = writeln!(out, "| {} | {x:.2e} | {y:.2e} | {angle:.2e} | {order} | {to_finest} | {paper} |", name(row));
    }
}

fn midpoint(out: &mut String, rows: &[&Row]) {
    if rows.is_empty() {
        return;
    }
    out.push_str(
        "\n## ReLCP with midpoint steps\n\n`time.stepping = \"midpoint\"`; not in the paper.\n\n\
         | dt | x | y | angle | order |\n| ---: | ---: | ---: | ---: | ---: |\n",
    );
    for Row { dt, x, y, angle, order, .. } in rows {
        let order = order.map_or(String::new(), |order| format!("{order:.2}"));
        let _ = writeln!(out, "| {dt} | {x:.2e} | {y:.2e} | {angle:.2e} | {order} |");
    }
}

fn work(out: &mut String, rows: &[Row]) {
    out.push_str(
        "\n## What each run cost\n\nOverlaps are the largest of all steps; that of smooth surfaces is what a run with sub-spheres does not see.\n\n\
         | run | largest error | steps | ms | products | recursions | rows a step | overlap | overlap of sub-spheres |\n\
         | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let name = super::Case { scheme: row.scheme, dt: row.dt, spheres: row.spheres, side: row.side }.name();
        let proxy = row.proxy_overlap.map_or(String::new(), |overlap| format!("{overlap:.1e}"));
        let _ = writeln!(
            out,
            "| {name} | {:.2e} | {} | {:.1} | {} | {} | {:.2} | {:.1e} | {proxy} |",
            row.worst, row.steps, row.milliseconds, row.products, row.recursions, row.constraints, row.max_overlap
        );
    }
}
