//! Plots of a measurement: one figure of a measure's values over time, with a panel for each quantity, and one of its
//! profile in a few states, as curves or as bars.

mod bars;
mod curves;
mod words;

use super::{Cell, Column, Counts, Marks, Measure, Measured, Profile, Spread};
use crate::figure::Figure;
use crate::figure::drawing::{self, COLOURS, Failed};
use curves::{Curve, Panel, Point};
use plotters::prelude::*;

/// The largest number of states whose profiles are drawn as curves, and as bars, including the last state with a
/// profile.
const STATES: usize = 5;
const STATES_OF_BARS: usize = 3;

/// The position of the last time on the viridis scale, whose end is too light on white.
const LIGHTEST: f64 = 0.85;

/// A row of a profile with fewer counts is pale: its error exceeds a sixth of its value.
const FEW: f64 = 30.0;

/// A plot that could not be drawn: its name and the error.
type Undrawn = (String, String);

/// The name of a figure whose first panel has these columns, without file extension.
pub(super) fn time_name(columns: &[&str]) -> String {
    columns.first().copied().unwrap_or_default().into()
}

/// The name of a measure's profile.
pub(super) fn profile_name(measure: &str) -> String {
    format!("{measure}_profile")
}

/// All figures with data, by name. A single state gives no curve over time.
pub(super) fn plots(measured: &Measured) -> Result<Vec<(String, Figure)>, Undrawn> {
    let mut plots = Vec::new();
    for (at, measure) in measured.measures.iter().enumerate() {
        let panels: Vec<Panel> =
            measure.about().plots.iter().filter_map(|names| over_time(measured, *measure, names)).collect();
        if let (Some(first), false) = (measure.about().plots.first(), panels.is_empty()) {
            let name = time_name(first);
            let drawn = curves::draw(&name, words::OVER_TIME, &panels, measured.frame.planar);
            plots.push((name, Some(drawn)));
        }
        if let Some(profile) = measure.profile() {
            plots.push((profile_name(measure.name()), of_profile(measured, at, &profile)));
        }
    }
    let drawn = plots.into_iter().filter_map(|(name, drawn)| Some((name, drawn?)));
    drawn
        .map(|(name, drawn)| drawn.map(|figure| (name.clone(), figure)).map_err(|what| (name, what.to_string())))
        .collect()
}

/// The panel of some columns over time; none where no column has two values.
fn over_time(measured: &Measured, measure: &'static dyn Measure, names: &[&str]) -> Option<Panel> {
    let columns: Vec<&Column> =
        names.iter().filter_map(|name| measure.columns().iter().find(|c| c.name == *name)).collect();
    let quantity = words::of_column(columns.first()?.name).0;
    let curve = |(column, colour): (&&Column, RGBColor)| {
        let point = |state: usize| {
            let y = measured.value(state, column.name)?;
            Some(Point { x: measured.times[state], y, error: 0.0, noisy: false })
        };
        let points = (0..measured.len()).filter_map(point).collect();
        Curve { name: words::of_column(column.name).1.into(), points, colour }
    };
    let curves = columns.iter().zip(COLOURS.into_iter().cycle()).map(curve);
    let curves: Vec<Curve> = curves.filter(|curve| curve.points.len() > 1).collect();
    (!curves.is_empty()).then_some(Panel { quantity, curves })
}

/// The figure of the profile of the measure `at`; none where no state has a row.
fn of_profile(measured: &Measured, at: usize, profile: &Profile) -> Option<Result<Figure, Failed>> {
    let measure = measured.measures[at].name();
    let title = profile_name(measure);
    let [across, up] = words::of_profile(measure);
    let rows =
        |state: usize| measured.found[at][state].as_ref().ok().map(|found| &found.rows).filter(|rows| !rows.is_empty());
    let states: Vec<usize> = (0..measured.len()).filter(|state| rows(*state).is_some()).collect();
    let last = *states.last()?;
    let bars = |state: usize| {
        let bar = |row: &Vec<Cell>| Some((row[0]?, row[profile.drawn]?));
        (time(measured, state), rows(state).into_iter().flatten().filter_map(bar).collect::<Vec<_>>())
    };
    match profile.marks {
        Marks::Curves => {
            let curves = curves_of(measured, at, profile);
            (!curves.is_empty())
                .then(|| curves::draw(&title, across, &[Panel { quantity: up, curves }], measured.frame.planar))
        }
        Marks::Bars => {
            let states: Vec<_> = spaced(states.len(), STATES_OF_BARS).into_iter().map(|k| bars(states[k])).collect();
            Some(bars::of_sizes(&title, [across, up], &states))
        }
        Marks::Kinds => {
            let named = |row: &Vec<Cell>| Some((bars::kind(&measured.frame, measure, row), row[profile.drawn]?));
            let mut kinds: Vec<_> = rows(last).into_iter().flatten().filter_map(named).collect();
            // Where all walls have one surface its number says nothing.
            if kinds.iter().all(|(kind, _)| kind.ends_with(bars::FIRST_FACE)) {
                kinds.iter_mut().for_each(|(kind, _)| kind.truncate(kind.len() - bars::FIRST_FACE.len()));
            }
            let name = format!("{}, {}", words::named(up, 0, measured.frame.planar), time(measured, last));
            Some(bars::of_kinds(&title, &name, kinds))
        }
    }
}

fn time(measured: &Measured, state: usize) -> String {
    format!("t = {}", drawing::shortest(measured.times[state], 3))
}

fn curves_of(measured: &Measured, at: usize, profile: &Profile) -> Vec<Curve> {
    let point = |row: &Vec<Cell>| {
        let (x, y) = (row[0]?, row[profile.drawn]?);
        let count = profile.counts.and_then(|counts| row[counts.column]);
        let error = profile.counts.zip(count).map_or(0.0, |(counts, count)| counts.error(row, y, count));
        Some(Point { x, y, error, noisy: count.is_some_and(|count| count < FEW) })
    };
    let curve = |state: usize| {
        let rows = &measured.found[at][state].as_ref().ok()?.rows;
        let points: Vec<_> = rows.iter().filter_map(point).collect();
        (!points.is_empty()).then(|| Curve { name: time(measured, state), points, colour: BLACK })
    };
    let curves: Vec<Curve> = (0..measured.len()).filter_map(curve).collect();
    let chosen = spaced(curves.len(), STATES);
    let last = chosen.len().saturating_sub(1).max(1) as f64;
    let coloured = |(k, at): (usize, usize)| {
        let colour = ViridisRGB.get_color(LIGHTEST * (1.0 - k as f64 / last));
        Curve { colour, ..curves[at].clone() }
    };
    chosen.into_iter().enumerate().map(coloured).collect()
}

impl Counts {
    /// The standard error of a value in a row with this count.
    fn error(self, row: &[Cell], value: f64, count: f64) -> f64 {
        match self.spread {
            _ if count <= 0.0 => 0.0,
            Spread::OfCount => value.abs() / count.sqrt(),
            Spread::OfMean(deviation) => deviation / count.sqrt(),
            Spread::Column(column) => row.get(column).copied().flatten().unwrap_or(0.0),
        }
    }
}

/// Which of `all` states are drawn: up to `most`, evenly spaced, and the last.
fn spaced(all: usize, most: usize) -> Vec<usize> {
    let drawn = most.min(all);
    (1..=drawn).map(|k| k * all / drawn - 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_states_drawn_are_spread_over_all_and_the_last_is_among_them() {
        assert_eq!(spaced(12, 5), [1, 3, 6, 8, 11]);
        assert_eq!((spaced(3, 5), spaced(0, 5), spaced(9, 3)), (vec![0, 1, 2], vec![], vec![2, 5, 8]));
    }
}
