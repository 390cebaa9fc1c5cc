//! What the study is to show, and the paper's figures.

use super::super::{Cost, Reached, Target, cost_at};
use super::{Reference, Row, Scheme, Side};

/// Errors of x, y and angle at steps of the paper's scheme, from its Table 1. That at 1e-5 is zero as it is the
/// reference there.
pub(super) const PAPER_EULER: [(f64, [f64; 3]); 5] = [
    (1e-1, [2.4530, 1.0111, 0.1078]),
    (1e-2, [0.0256, 0.0243, 0.0041]),
    (1e-3, [0.0048, 0.0044, 0.0006]),
    (1e-4, [0.0026, 0.0024, 0.0003]),
    (1e-5, [0.0, 0.0, 0.0]),
];

/// The same with sub-spheres, by their number, at steps of 1e-5.
pub(super) const PAPER_MULTISPHERE: [(u32, [f64; 3]); 6] = [
    (3, [2.1326, 0.2473, 1.2034]),
    (7, [0.2086, 0.1361, 0.0145]),
    (13, [0.0574, 0.0422, 0.0044]),
    (17, [0.0309, 0.0230, 0.0023]),
    (23, [0.0120, 0.0087, 0.0008]),
    (27, [0.0103, 0.0077, 0.0007]),
];

/// Bounds of the ratio of errors at steps of which one is ten times the other.
const RATIO: [f64; 2] = [8.0, 12.0];

/// The least order of the midpoint step.
const ORDER: f64 = 1.8;

/// How much less time the midpoint step is to take for an error.
const LESS_TIME: [(f64, f64); 2] = [(1e-3, 10.0), (1e-5, 50.0)];

/// The step of the ReLCP run that sub-spheres are compared with.
const FINE: f64 = 1e-3;

/// A reference is good enough for an error of ten times its own uncertainty.
const CERTAINTY: f64 = 10.0;

/// The paper's errors of what a row measures.
pub(super) fn of_paper(row: &Row) -> Option<[f64; 3]> {
    match (row.scheme, row.spheres) {
        (Scheme::Euler, _) => PAPER_EULER.iter().find(|(dt, _)| *dt == row.dt).map(|(_, errors)| *errors),
        (_, Some(count)) => PAPER_MULTISPHERE.iter().find(|(n, _)| *n == count).map(|(_, errors)| *errors),
        _ => None,
    }
}

pub(super) fn of(rows: &[Row], side: Side, scheme: Scheme) -> Vec<&Row> {
    rows.iter().filter(|row| (row.side, row.scheme) == (side, scheme)).collect()
}

pub(super) fn targets(rows: &[Row], references: &[Reference; 2]) -> Vec<Target> {
    let mut targets = Vec::new();
    for side in [Side::Left, Side::Right] {
        let of = |scheme| of(rows, side, scheme);
        let euler = of(Scheme::Euler);
        let refined = [below_paper(&euler), first_order(&euler), slow_spheres(&euler, &of(Scheme::Multisphere))];
        targets
            .extend(refined.map(|target| Target { wanted: format!("{}: {}", side.name(), target.wanted), ..target }));
    }
    let (euler, midpoint) = (of(rows, Side::Right, Scheme::Euler), of(rows, Side::Right, Scheme::Midpoint));
    targets.push(second_order(&midpoint));
    for (error, times) in LESS_TIME {
        targets.push(cheaper(&euler, &midpoint, error, times));
    }
    let uncertainty = references.iter().map(Reference::worst_difference).fold(0.0, f64::max);
    let finest = rows.iter().filter(|row| row.scheme != Scheme::Multisphere).map(|row| row.worst);
    let finest = finest.fold(f64::INFINITY, f64::min);
    targets.push(Target::new(
        format!("two schemes agree on the references to {:.0}% of the smallest error", 100.0 / CERTAINTY),
        format!("{uncertainty:.1e} apart, smallest error {finest:.1e}"),
        finest.is_finite().then_some(CERTAINTY * uncertainty <= finest),
    ));
    targets
}

fn below_paper(euler: &[&Row]) -> Target {
    // The paper's own finest run has no error there.
    let compared = euler.iter().filter_map(|row| Some((row, of_paper(row).filter(|errors| errors[0] > 0.0)?)));
    let found: Vec<(f64, f64)> =
        compared.map(|(row, [x, y, angle])| (row.dt, (row.x / x).max(row.y / y).max(row.angle / angle))).collect();
    let words: Vec<String> = found.iter().map(|(dt, part)| format!("{part:.2} at {dt:.0e}")).collect();
    Target::new(
        "ReLCP's errors at or under the paper's at every dt above 1e-5",
        format!("largest ratio of ours to the paper's: {}", words.join(", ")),
        (!found.is_empty()).then(|| found.iter().all(|(_, part)| *part <= 1.0)),
    )
}

fn first_order(euler: &[&Row]) -> Target {
    let ratios: Vec<f64> = euler.windows(2).map(|pair| pair[0].worst / pair[1].worst).collect();
    let words: Vec<String> = ratios.iter().map(|ratio| format!("{ratio:.2}")).collect();
    Target::new(
        format!("ReLCP's largest error falls by {} to {} a decade of dt", RATIO[0], RATIO[1]),
        words.join(", "),
        (!ratios.is_empty()).then(|| ratios.iter().all(|ratio| (RATIO[0]..=RATIO[1]).contains(ratio))),
    )
}

fn second_order(midpoint: &[&Row]) -> Target {
    let orders: Vec<f64> = midpoint.iter().filter_map(|row| row.order).collect();
    let words: Vec<String> = orders.iter().map(|order| format!("{order:.2}")).collect();
    Target::new(
        format!("midpoint steps are of order {ORDER} at least at every halving"),
        words.join(", "),
        (!orders.is_empty()).then(|| orders.iter().all(|order| *order >= ORDER)),
    )
}

fn slow_spheres(euler: &[&Row], spheres: &[&Row]) -> Target {
    let wanted = format!(
        "LCP-MS converges slowly towards ReLCP: its errors fall with the spheres, and the most still err more than ReLCP at dt {FINE:.0e}"
    );
    let fine = euler.iter().find(|row| row.dt == FINE);
    let ([.., last], Some(fine)) = (spheres, fine) else { return Target::new(wanted, "", None) };
    let falling = spheres.windows(2).all(|pair| pair[1].worst < pair[0].worst);
    let found = format!(
        "{} at every count; {} spheres err {:.1e} in {:.0} ms, ReLCP at dt {FINE:.0e} {:.1e} in {:.0} ms",
        if falling { "falling" } else { "not falling" },
        last.spheres.unwrap_or_default(),
        last.worst,
        last.milliseconds,
        fine.worst,
        fine.milliseconds
    );
    Target::new(wanted, found, Some(falling && last.worst > fine.worst))
}

fn cheaper(euler: &[&Row], midpoint: &[&Row], error: f64, times: f64) -> Target {
    let wanted = format!("midpoint takes {times:.0} times less time than the paper's step for an error of {error:.0e}");
    let cost = |rows: &[&Row], of: fn(&Row) -> f64| {
        let runs: Vec<(f64, f64)> = rows.iter().map(|row| (of(row), row.worst)).collect();
        cost_at(&runs, error)
    };
    let time = |row: &Row| row.milliseconds;
    let (Some(a), Some(b)) = (cost(euler, time), cost(midpoint, time)) else {
        return Target::new(wanted, "the runs do not get there", None);
    };
    let products = |row: &Row| row.products as f64;
    let in_products = match (cost(euler, products), cost(midpoint, products)) {
        (Some(a), Some(b)) => format!("; {:.1} times fewer products", a.value / b.value),
        _ => String::new(),
    };
    let ratio = a.value / b.value;
    let found = format!("{ratio:.1} times less: {} against {}{in_products}", said(a), said(b));
    // What is reached already may be cheaper still: that helps the midpoint step, and would flatter it on the other
    // side.
    Target::new(wanted, found, (a.reached != Reached::Already).then_some(ratio >= times))
}

fn said(Cost { value, reached }: Cost) -> String {
    match reached {
        Reached::Already => format!("at most {value:.1} ms"),
        Reached::Between => format!("{value:.1} ms"),
        Reached::Beyond => format!("{value:.1} ms (extrapolated)"),
    }
}
