//! Radius and rate of expansion.
//!
//! The radius of gyration is `sqrt(<|x - c|^2>)` of the centres about their mean `c` (P. J. Flory, "Principles of
//! Polymer Chemistry", 1953, chapter X); the outermost radius the distance from `c` to the farthest point of a body.
//! The expansion rate is the derivative of the outermost radius: that of the parabola through a state and its
//! neighbours in time, at the ends that of the chord (B. Fornberg, Math. Comp. 51, 699 (1988)).

use super::{About, Cell, Column, Found, LeftOut, Measure, View, cell};

const COLUMNS: [Column; 3] = [
    Column { name: "radius_gyration", what: "radius of gyration of the centres; a length" },
    Column {
        name: "radius_outermost",
        what: "distance from the mean of the centres to the farthest point of a body; a length",
    },
    Column { name: "expansion_rate", what: "derivative of radius_outermost by time; length over time" },
];

/// The indices of the columns.
const OUTERMOST: usize = 1;
const RATE: usize = 2;

/// Radius and rate of expansion.
pub(super) struct Radius;

impl Measure for Radius {
    fn about(&self) -> &'static About {
        &About {
            name: "radius",
            line: "radius of gyration, outermost radius and its rate of expansion",
            columns: &COLUMNS,
            profile: None,
            plots: &[&["radius_gyration", "radius_outermost"], &["expansion_rate"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        view.in_open_space()?;
        Ok(Found { values: vec![cell(gyration(view)), cell(outermost(view)), None], ..Found::default() })
    }

    fn over_time(&self, times: &[f64], found: &mut [Result<Found, LeftOut>]) {
        let known: Vec<(usize, f64, f64)> =
            (0..times.len()).filter_map(|k| Some((k, times[k], found[k].as_ref().ok()?.values[OUTERMOST]?))).collect();
        for (at, &(k, ..)) in known.iter().enumerate() {
            if let Ok(found) = &mut found[k] {
                found.values[RATE] = slope(&known, at);
            }
        }
        if let [only] = known.as_slice()
            && let Ok(found) = &mut found[only.0]
        {
            found.remark = Some("one state alone has no rate of expansion".into());
        }
    }
}

fn slope(known: &[(usize, f64, f64)], at: usize) -> Cell {
    let chord = |a: usize, b: usize| {
        let (from, to) = (known.get(a)?, known.get(b)?);
        cell((to.2 - from.2) / (to.1 - from.1))
    };
    let before = at.checked_sub(1).and_then(|before| chord(before, at));
    match (before, chord(at, at + 1)) {
        (Some(before), Some(after)) => {
            let (back, ahead) = (known[at].1 - known[at - 1].1, known[at + 1].1 - known[at].1);
            cell((ahead * before + back * after) / (back + ahead))
        }
        (before, after) => before.or(after),
    }
}

/// The radius of gyration of the centres.
pub(super) fn gyration(view: &View<'_>) -> f64 {
    let position = &view.bodies().position;
    let squares: f64 = position.iter().map(|x| x.distance_squared(view.centre)).sum();
    (squares / position.len() as f64).sqrt()
}

/// The distance of the farthest point of a body from the centre.
pub(super) fn outermost(view: &View<'_>) -> f64 {
    view.bodies().outermost_from(view.centre)
}
