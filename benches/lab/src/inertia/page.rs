//! The page of the study.

use super::{HeapRow, Order, STEPPINGS, Size, Study, TopRow};
use crate::machine::machine;
use crate::paper::{COMPUTED_BY, Target, target_table};
use relcp::scene::Stepping;
use std::fmt::Write as _;

/// What tops may drift by in 64-bit and in 32-bit floats. Roundings of 1e-16 and 6e-8 add up as random walks of 630,000
/// and 2,000 steps; the rod's energy answers to a turn by 30 times, its ratio of moments.
const DRIFT: f64 = 1e-11;
const DRIFT_F32: f64 = 2e-4;
/// How near to two the order of attitudes is to be.
const ORDER: [f64; 2] = [1.9, 2.1];

fn name(stepping: Stepping) -> &'static str {
    match stepping {
        Stepping::Midpoint => "midpoint",
        _ => "Euler",
    }
}

fn is_f32(row: &TopRow) -> bool {
    row.computed_by.ends_with("f32")
}

/// The orders from each step to the next.
fn orders(rows: &[Order]) -> Vec<f64> {
    let same = rows.windows(2).filter(|pair| pair[0].stepping == pair[1].stepping);
    same.map(|pair| (pair[0].error / pair[1].error).ln() / (pair[0].angle / pair[1].angle).ln()).collect()
}

/// What the study is to show.
pub(super) fn targets(study: &Study) -> Vec<Target> {
    let mut targets = Vec::new();
    for (f32, bound, what) in [(false, DRIFT, "64"), (true, DRIFT_F32, "32")] {
        let rows: Vec<&TopRow> = study.tops().iter().filter(|row| is_f32(row) == f32).collect();
        let worst = |of: fn(&TopRow) -> f64| rows.iter().map(|row| of(row)).fold(0.0, f64::max);
        let [momentum, energy] = [worst(|row| row.momentum), worst(|row| row.energy)];
        targets.push(Target::new(
            format!("tops keep angular momentum and energy in {what}-bit floats: changes of at most {bound:.0e}"),
            format!("{momentum:.1e} and {energy:.1e}"),
            (!rows.is_empty()).then_some(momentum <= bound && energy <= bound),
        ));
    }
    let found = orders(study.orders());
    targets.push(Target::new(
        "attitudes are of second order",
        found.iter().map(|order| format!("{order:.2}")).collect::<Vec<_>>().join(", "),
        (!found.is_empty()).then(|| found.iter().all(|order| (ORDER[0]..=ORDER[1]).contains(order))),
    ));
    for stepping in STEPPINGS {
        let rows: Vec<&HeapRow> = study.heaps().iter().filter(|row| row.stepping == stepping).collect();
        let rises: u64 = rows.iter().map(|row| row.rises).sum();
        let steps: u64 = rows.iter().map(|row| row.steps).sum();
        targets.push(Target::new(
            format!("no step of a heap adds energy beyond the tolerances, {} steps", name(stepping)),
            format!("{rises} of {steps} steps of {} heaps do", rows.len()),
            (!rows.is_empty()).then_some(rises == 0),
        ));
    }
    targets
}

pub(super) fn page(study: &Study) -> String {
    let Size { turns, end, .. } = study.size();
    let mut out = format!(
        "# What inertial motion keeps\n\n\
         Tops that turn freely, without force and torque, and heaps that are dropped with spins and settle. The turn of a step is by the midpoint rule of J. C. Simo and \
         K. K. Wong (1991) in the form of the Cayley map; [the step size](../../timestep.md) has the equations.\n\n\
         * Tops: {turns} turns on the CPU, fewer on a device (the table has the steps); changes are the largest of angular momentum in space and of energy at any time, as parts of what they were.\n\
         * Heaps: 20 spheres, rods, ellipsoids or rings, dropped from up to 8 with velocities of up to 1 and spins of up to 8 in each component under gravity of {:.2}, on a plane or in a box, \
         followed to time {end}. After every step the sum of kinetic and potential energy is computed from the accepted state. Contact forces may part what overlaps within the tolerances: \
         a step that rises by more than the sum of its forces times both tolerances is counted, for midpoint steps beyond m (g dt)^2 / 8 a body, as half of gravity's impulse comes after contact's.\n\
         * Made by `cargo run --release -p relcp-lab -- inertia`. {}. Heaps and attitudes are computed by {COMPUTED_BY}.\n",
        9.81,
        machine(),
    );
    out.push_str("\n## What it shows\n\n");
    out.push_str(&target_table(&study.targets()));
    write_tops(&mut out, study.tops());
    write_orders(&mut out, study.orders());
    write_heaps(&mut out, study.heaps());
    out
}

fn write_tops(out: &mut String, rows: &[TopRow]) {
    out.push_str(
        "\n## Tops\n\n| top | computed by | stepping | angle a step | steps | turns | angular momentum off by | energy off by | energy at the end off by |\n\
         | --- | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {:.0} | {:.1e} | {:.1e} | {:.1e} |",
            row.top,
            row.computed_by,
            name(row.stepping),
            row.angle,
            row.steps,
            row.turns,
            row.momentum,
            row.energy,
            row.last_energy
        );
    }
}

fn write_orders(out: &mut String, rows: &[Order]) {
    out.push_str(
        "\n## Attitude of the prolate top\n\nAgainst the closed form, after a time in which it turns by 16 radians.\n\n| stepping | angle a step | attitude off by, radians |\n\
         | --- | ---: | ---: |\n",
    );
    for Order { stepping, angle, error } in rows {
        let _ = writeln!(out, "| {} | {angle} | {error:.2e} |", name(*stepping));
    }
}

fn write_heaps(out: &mut String, rows: &[HeapRow]) {
    out.push_str(
        "\n## Heaps\n\nEnergies as parts of that at the start.\n\n| heap | bodies | on or in a | stepping | dt | steps | energy at the end | most | largest rise in a step | beyond the tolerances | such steps | \
         largest overlap | steps out of tolerance | with bodies that passed |\n| ---: | --- | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {:.3} | {:.3} | {:.1e} | {:.1e} | {} | {:.1e} | {} | {} |",
            row.number,
            row.shape,
            row.place,
            name(row.stepping),
            row.dt,
            row.steps,
            row.last_energy / row.first_energy,
            row.most_energy,
            row.most_rise,
            row.unexplained,
            row.rises,
            row.max_overlap,
            row.missed,
            row.passed
        );
    }
}
