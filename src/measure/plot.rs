//! Plots of a measurement, as SVG: numbers over time, and profiles of a few states.

use super::{Cell, Measured};
use plotters::prelude::*;

/// Width and height, in pixels.
const SIDES: (u32, u32) = (800, 500);

/// Most states whose profiles are drawn, the last of them the last state that has one.
const STATES: usize = 5;

/// A name and its points.
type Curve = (String, Vec<(f64, f64)>);

/// A plot that failed: its file and what went wrong.
type Failed = (String, String);

/// The file of a plot over time.
pub(super) fn time_file(columns: &[&str]) -> String {
    format!("{}.svg", columns.first().copied().unwrap_or_default())
}

/// The file of a measure's profile.
pub(super) fn profile_file(measure: &str) -> String {
    format!("{measure}_profile.svg")
}

/// All plots that have anything to show, by file. A single state has no course over time.
pub(super) fn plots(measured: &Measured) -> Result<Vec<(String, String)>, Failed> {
    let mut plots = Vec::new();
    for (at, measure) in measured.measures.iter().enumerate() {
        for columns in measure.plots() {
            let curves =
                columns.iter().map(|column| over_time(measured, column)).filter(|(_, points)| points.len() > 1);
            plots.push((
                time_file(columns),
                measure.about().to_owned(),
                ["time".to_owned(), columns.join(", ")],
                curves.collect(),
            ));
        }
        if let Some(profile) = measure.profile() {
            let [x, y] = [profile.columns[0].name, profile.columns[profile.drawn].name].map(String::from);
            plots.push((
                profile_file(measure.name()),
                measure.about().to_owned(),
                [x, y],
                profiles(measured, at, profile.drawn),
            ));
        }
    }
    let shown = plots.into_iter().filter(|(.., curves): &(_, _, _, Vec<Curve>)| !curves.is_empty());
    shown
        .map(|(file, title, axes, curves)| match draw(&title, &axes, &curves) {
            Ok(svg) => Ok((file, svg)),
            Err(what) => Err((file, what)),
        })
        .collect()
}

fn over_time(measured: &Measured, column: &str) -> Curve {
    let point = |state: usize| Some((measured.times[state], measured.value(state, column)?));
    (column.to_owned(), (0..measured.len()).filter_map(point).collect())
}

fn profiles(measured: &Measured, at: usize, drawn: usize) -> Vec<Curve> {
    let point = |row: &Vec<Cell>| Some((row[0]?, row[drawn]?));
    let curve = |state: usize| {
        let rows = &measured.found[at][state].as_ref().ok()?.rows;
        let points: Vec<_> = rows.iter().filter_map(point).collect();
        (!points.is_empty()).then(|| (format!("time {}", round(measured.times[state])), points))
    };
    let curves: Vec<Curve> = (0..measured.len()).filter_map(curve).collect();
    spaced(curves.len()).into_iter().map(|k| curves[k].clone()).collect()
}

/// Which of `all` states are drawn: up to [`STATES`], evenly spaced, and the last.
fn spaced(all: usize) -> Vec<usize> {
    let drawn = STATES.min(all);
    (1..=drawn).map(|k| k * all / drawn - 1).collect()
}

/// Six digits, as times like 0.30000000000000004 are called 0.3.
fn round(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// The label of a tick of an axis of this span: what is left of zero where steps are added up is zero.
fn label(value: f64, span: f64) -> String {
    if value.abs() < 1e-9 * span { "0".into() } else { round(value).to_string() }
}

/// The range of values, widened where it is empty.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if high > low {
        return (low, high);
    }
    let margin = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
    (low - margin, high + margin)
}

fn draw(title: &str, [x_name, y_name]: &[String; 2], curves: &[Curve]) -> Result<String, String> {
    let points = || curves.iter().flat_map(|(_, points)| points);
    let (x_low, x_high) = range(points().map(|point| point.0));
    // Zero belongs to the picture where it is not far.
    let (y_low, y_high) = range(points().map(|point| point.1));
    let y_low = if y_low > 0.0 && y_low < 0.5 * y_high { 0.0 } else { y_low };
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIDES).into_drawing_area();
        let failed = |e: &dyn std::fmt::Display| e.to_string();
        area.fill(&WHITE).map_err(|e| failed(&e))?;
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d(x_low..x_high, y_low..y_high + 0.05 * (y_high - y_low))
            .map_err(|e| failed(&e))?;
        let tick = |span: f64| move |value: &f64| label(*value, span);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc(x_name)
            .y_desc(y_name)
            .x_label_formatter(&tick(x_high - x_low))
            .y_label_formatter(&tick(y_high - y_low))
            .draw()
            .map_err(|e| failed(&e))?;
        for (k, (name, points)) in curves.iter().enumerate() {
            let colour = Palette99::pick(k).mix(1.0);
            let line = LineSeries::new(points.iter().copied(), colour.stroke_width(2)).point_size(2);
            chart
                .draw_series(line)
                .map_err(|e| failed(&e))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.2))
            .draw()
            .map_err(|e| failed(&e))?;
        area.present().map_err(|e| failed(&e))?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        assert_eq!(label(1.1102230246251565e-16, 1.8), "0");
        assert_eq!((label(0.30000000000000004, 1.0), label(-2e-7, 1e-6)), ("0.3".into(), "-0.0000002".into()));
    }

    #[test]
    fn the_curves_drawn_are_spread_over_the_states_and_the_last_is_among_them() {
        assert_eq!(spaced(12), [1, 3, 6, 8, 11]);
        assert_eq!((spaced(3), spaced(0)), (vec![0, 1, 2], vec![]));
    }
}
