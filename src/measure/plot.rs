//! Plots of a measurement: values over time, and profiles of a few states.

use super::{Cell, Column, Counts, Measured, Spread};
use crate::figure::Figure;
use crate::figure::backend::Sheet;
use crate::figure::drawing::{self, COLOURS, COLUMN, DOT, Failed, LINE, MARGIN, POINT, X_LABELS, Y_LABELS};
use crate::figure::head::{Head, Name};
use plotters::chart::ChartContext;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// Width and height in points: three quarters as high as wide.
const SIDES: [u32; 2] = [COLUMN, COLUMN * 3 / 4];

/// The largest number of states whose profiles are drawn, including the last state with a profile.
const STATES: usize = 5;

/// The position of the last time on the viridis scale, whose end is too light on white.
const LIGHTEST: f64 = 0.85;

/// A row of a profile with fewer counts is pale: its error exceeds a sixth of its value.
const FEW: f64 = 30.0;

/// The opacities of a band of errors, and of the pale part of a curve.
const BAND: f64 = 0.25;
const PALE: f64 = 0.35;

/// A point of a curve: its position, its error, and whether it is noisy.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    x: f64,
    y: f64,
    error: f64,
    noisy: bool,
}

/// A name, its points and its colour.
#[derive(Clone, Debug)]
struct Curve {
    name: String,
    points: Vec<Point>,
    colour: RGBColor,
}

/// A plot that could not be drawn: its name and the error.
type Undrawn = (String, String);

type Chart<'a, 'b> = ChartContext<'a, Sheet<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// The name of a plot over time, without file extension.
pub(super) fn time_name(columns: &[&str]) -> String {
    columns.first().copied().unwrap_or_default().into()
}

/// The name of a measure's profile.
pub(super) fn profile_name(measure: &str) -> String {
    format!("{measure}_profile")
}

/// All plots with data, by name. A single state gives no plot over time.
pub(super) fn plots(measured: &Measured) -> Result<Vec<(String, Figure)>, Undrawn> {
    let mut plots = Vec::new();
    for (at, measure) in measured.measures.iter().enumerate() {
        for names in measure.about().plots {
            let columns = || names.iter().filter_map(|name| measure.columns().iter().find(|c| c.name == *name));
            let curves = columns().zip(COLOURS.into_iter().cycle());
            let curves: Vec<Curve> = curves
                .map(|(column, colour)| over_time(measured, column, colour))
                .filter(|curve| curve.points.len() > 1)
                .collect();
            let y = match columns().collect::<Vec<_>>().as_slice() {
                [column] => labelled(column),
                several => several.first().map(|column| unit(column)).unwrap_or_default(),
            };
            plots.push((time_name(names), ["time".to_owned(), y], curves));
        }
        if let Some(profile) = measure.profile() {
            let axes = [0, profile.drawn].map(|column| labelled(&profile.columns[column]));
            plots.push((profile_name(measure.name()), axes, profiles(measured, at, profile.drawn, profile.counts)));
        }
    }
    let shown = plots.into_iter().filter(|(.., curves)| !curves.is_empty());
    shown
        .map(|(name, axes, curves)| match draw(&name, &axes, &curves) {
            Ok(figure) => Ok((name, figure)),
            Err(what) => Err((name, what.to_string())),
        })
        .collect()
}

/// A column's name with spaces, and its unit.
fn labelled(column: &Column) -> String {
    let unit = unit(column);
    let name = column.name.replace('_', " ").replace(" degrees", "");
    if unit.is_empty() { name } else { format!("{name} ({unit})") }
}

/// The unit of a column, in units of the scene, from the end of its description; empty for a pure number.
fn unit(column: &Column) -> String {
    if column.name.ends_with("_degrees") {
        return "degrees".into();
    }
    let last = column.what.rsplit("; ").next().unwrap_or_default();
    match last.strip_prefix("a ").unwrap_or(last) {
        unit @ ("length" | "length squared" | "force" | "length over time" | "force times length over time") => {
            unit.into()
        }
        _ => String::new(),
    }
}

fn over_time(measured: &Measured, column: &Column, colour: RGBColor) -> Curve {
    let point = |state: usize| {
        let y = measured.value(state, column.name)?;
        Some(Point { x: measured.times[state], y, error: 0.0, noisy: false })
    };
    let points = (0..measured.len()).filter_map(point).collect();
    Curve { name: column.name.replace('_', " "), points, colour }
}

fn profiles(measured: &Measured, at: usize, drawn: usize, counts: Option<Counts>) -> Vec<Curve> {
    let point = |row: &Vec<Cell>| {
        let (x, y) = (row[0]?, row[drawn]?);
        let count = counts.and_then(|counts| row[counts.column]);
        let error = counts.zip(count).map_or(0.0, |(counts, count)| counts.error(row, y, count));
        Some(Point { x, y, error, noisy: count.is_some_and(|count| count < FEW) })
    };
    let curve = |state: usize| {
        let rows = &measured.found[at][state].as_ref().ok()?.rows;
        let points: Vec<_> = rows.iter().filter_map(point).collect();
        let name = format!("t = {}", drawing::shortest(measured.times[state], 3));
        (!points.is_empty()).then_some(Curve { name, points, colour: BLACK })
    };
    let curves: Vec<Curve> = (0..measured.len()).filter_map(curve).collect();
    let chosen = spaced(curves.len());
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

/// Which of `all` states are drawn: up to [`STATES`], evenly spaced, and the last.
fn spaced(all: usize) -> Vec<usize> {
    let drawn = STATES.min(all);
    (1..=drawn).map(|k| k * all / drawn - 1).collect()
}

/// The range of values, widened if it is empty.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if high > low {
        return (low, high);
    }
    let margin = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
    (low - margin, high + margin)
}

fn draw(title: &str, [x_name, y_name]: &[String; 2], curves: &[Curve]) -> Result<Figure, Failed> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let (x_low, x_high) = range(points().map(|point| point.x));
    // Errors of pale points do not affect the range. Zero is included if it is near.
    let sure = |point: &&Point| !point.noisy;
    let ends = |point: &Point| [point.y - point.error, point.y + point.error];
    let (y_low, y_high) = range(points().map(|point| point.y).chain(points().filter(sure).flat_map(ends)));
    let y_low = if y_low > 0.0 && y_low < 0.5 * y_high { 0.0 } else { y_low };
    drawing::draw(title, SIDES, |area| {
        let head = Head::new(COLUMN * POINT, "", names(curves));
        let rest = head.draw(area, head.height())?;
        let mut chart = ChartBuilder::on(&rest)
            .margin(MARGIN)
            .x_label_area_size(X_LABELS)
            .y_label_area_size(Y_LABELS)
            .build_cartesian_2d(x_low..x_high, y_low..y_high + 0.05 * (y_high - y_low))?;
        let tick = |span: f64| move |value: &f64| drawing::tick(*value, span);
        let mut axes = chart.configure_mesh();
        drawing::style(&mut axes);
        axes.x_labels(5)
            .y_labels(5)
            .x_desc(x_name)
            .y_desc(y_name)
            .x_label_formatter(&tick(x_high - x_low))
            .y_label_formatter(&tick(y_high - y_low))
            .draw()?;
        curves.iter().try_for_each(|curve| draw_curve(&mut chart, curve))
    })
}

/// Draws the band of errors, then the curve, pale where it is noisy. A single point is a dot.
fn draw_curve(chart: &mut Chart<'_, '_>, curve: &Curve) -> Result<(), Failed> {
    let (points, colour) = (&curve.points, curve.colour);
    let at = |point: &Point| (point.x, point.y);
    let has_band =
        |pair: &&[Point]| pair.iter().all(|point| !point.noisy) && pair.iter().any(|point| point.error > 0.0);
    for pair in points.windows(2).filter(has_band) {
        let [a, b] = [pair[0], pair[1]];
        let corners = [(a.x, a.y - a.error), (b.x, b.y - b.error), (b.x, b.y + b.error), (a.x, a.y + a.error)];
        chart.draw_series([Polygon::new(corners, colour.mix(BAND))])?;
    }
    // Runs of points in the same style; each begins with the last point of the one before.
    let mut first = 0;
    while first + 1 < points.len() {
        let noisy = |k: usize| points[k].noisy || points[k + 1].noisy;
        let last = (first + 1..points.len() - 1).find(|k| noisy(*k) != noisy(first)).unwrap_or(points.len() - 1);
        let style = if noisy(first) { colour.mix(PALE).stroke_width(LINE / 2) } else { colour.stroke_width(LINE) };
        chart.draw_series([PathElement::new(points[first..=last].iter().map(at).collect::<Vec<_>>(), style)])?;
        first = last;
    }
    if let [point] = points.as_slice() {
        chart.draw_series([Circle::new(at(point), DOT, colour.filled())])?;
    }
    Ok(())
}

/// The legend; none for a single curve, which the axis names.
fn names(curves: &[Curve]) -> Vec<Name> {
    let mut names = Vec::new();
    if curves.len() > 1 || curves.iter().any(|curve| curve.name.starts_with("t =")) {
        names.extend(curves.iter().map(|curve| Name { text: curve.name.clone(), colour: Some(curve.colour) }));
    }
    if curves.iter().any(|curve| curve.points.iter().any(|point| point.noisy)) {
        let text = format!("pale: fewer than {FEW} counted; bands: standard errors");
        names.push(Name { text, colour: None });
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curves_drawn_are_spread_over_the_states_and_the_last_is_among_them() {
        assert_eq!(spaced(12), [1, 3, 6, 8, 11]);
        assert_eq!((spaced(3), spaced(0)), (vec![0, 1, 2], vec![]));
    }

    #[test]
    fn labels_have_words_and_units() {
        let column = |name, what| labelled(&Column { name, what });
        assert_eq!(
            column("correlation_length", "where C(r) first falls to 1/e; a length"),
            "correlation length (length)"
        );
        assert_eq!(column("nematic_order", "order of all axes: 0 isotropic, 1 aligned"), "nematic order");
        assert_eq!(column("nematic_director_degrees", "angle of the director"), "nematic director (degrees)");
    }

    #[test]
    fn few_counts_are_pale_with_bands_and_a_point_alone_is_a_dot() {
        let point = |x: f64, noisy| Point { x, y: 1.0 + x, error: 0.1, noisy };
        let curve = |points: Vec<Point>| Curve { name: "t = 1".into(), points, colour: BLACK };
        let axes = ["distance (length)".to_owned(), "correlation".to_owned()];
        let draw = |points| draw("correlation", &axes, &[curve(points)]).unwrap().svg();
        let svg = draw(vec![point(0.0, false), point(1.0, false), point(2.0, true)]);
        let [blue, pale] =
            ["fill=\"#000000\" fill-opacity=\"0.25\"", "stroke-opacity=\"0.35\""].map(|ink| svg.matches(ink).count());
        assert!(svg.contains("pale: fewer than 30") && blue == 1 && pale == 1, "{svg}");
        assert!(svg.contains("width=\"86.08mm\"") && svg.contains("font-size=\"80\""), "{svg}");
        // A dot has arcs; the ticks and lines of the axes have none.
        assert!(!svg.contains('Q') && draw(vec![point(1.0, false)]).contains('Q'));
    }
}
