//! Plots of a measurement, as SVG: numbers over time, and profiles of a few states.
//!
//! They are made to go into a paper as they are: one column wide, text of eight points, colours that colour-blind
//! readers tell apart (Okabe and Ito 2008; times by the viridis scale), names over the axes and not on the data.

use super::{Cell, Column, Counts, Measured, Spread};
use plotters::chart::ChartContext;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Width and height in points, 86 mm by 64 mm, and the pixels of a point.
const SIDES: (u32, u32) = (244, 182);
const POINT: u32 = 4;
/// Sizes in pixels: text of 8 points, for which plotters wants a quarter more, curves of 1.2 and axes of half a point.
const TEXT: u32 = 10 * POINT;
const LINE: u32 = 5;
const AXIS: u32 = 2;
/// The mean width of a letter, in parts of the text's size.
const LETTER: f64 = 0.45;
/// The sample of a curve before its name.
const SAMPLE: i32 = 40;

/// Colours of numbers of different kinds.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// Most states whose profiles are drawn, the last of them the last state that has one.
const STATES: usize = 5;

/// The last of the times stands here on the viridis scale, whose end is too light on white.
const LIGHTEST: f64 = 0.85;

/// A row of a profile that fewer things were counted for is pale: its error is over a sixth of what it tells.
const FEW: f64 = 30.0;

/// Parts of a colour that stay in a band of errors, and in the pale end of a curve.
const BAND: f64 = 0.25;
const PALE: f64 = 0.35;

/// A point of a curve: where, how far it may be off, and whether it is worth little.
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

/// A plot that failed: its file and what went wrong.
type Failed = (String, String);

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

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
        for names in measure.plots() {
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
            plots.push((time_file(names), ["time".to_owned(), y], curves));
        }
        if let Some(profile) = measure.profile() {
            let axes = [0, profile.drawn].map(|column| labelled(&profile.columns[column]));
            plots.push((profile_file(measure.name()), axes, profiles(measured, at, profile.drawn, profile.counts)));
        }
    }
    let shown = plots.into_iter().filter(|(.., curves)| !curves.is_empty());
    shown
        .map(|(file, axes, curves)| match draw(&axes, &curves) {
            Ok(svg) => Ok((file, svg)),
            Err(what) => Err((file, what.to_string())),
        })
        .collect()
}

/// A column's name in words, with its unit.
fn labelled(column: &Column) -> String {
    let unit = unit(column);
    let name = column.name.replace('_', " ").replace(" degrees", "");
    if unit.is_empty() { name } else { format!("{name} ({unit})") }
}

/// The unit of a column, in units of the scene, as its description ends; empty for a pure number.
fn unit(column: &Column) -> String {
    if column.name.ends_with("_degrees") {
        return "degrees".into();
    }
    let last = column.what.rsplit("; ").next().unwrap_or_default();
    match last.strip_prefix("a ").unwrap_or(last) {
        unit @ ("length" | "force" | "length over time" | "force times length over time") => unit.into(),
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
        let error = counts.zip(count).map_or(0.0, |(counts, count)| counts.error(y, count));
        Some(Point { x, y, error, noisy: count.is_some_and(|count| count < FEW) })
    };
    let curve = |state: usize| {
        let rows = &measured.found[at][state].as_ref().ok()?.rows;
        let points: Vec<_> = rows.iter().filter_map(point).collect();
        let name = format!("t = {}", round(measured.times[state], 3));
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
    /// The standard error of a value that is made from so many.
    fn error(self, value: f64, count: f64) -> f64 {
        match self.spread {
            _ if count <= 0.0 => 0.0,
            Spread::OfCount => value.abs() / count.sqrt(),
            Spread::OfMean(deviation) => deviation / count.sqrt(),
        }
    }
}

/// Which of `all` states are drawn: up to [`STATES`], evenly spaced, and the last.
fn spaced(all: usize) -> Vec<usize> {
    let drawn = STATES.min(all);
    (1..=drawn).map(|k| k * all / drawn - 1).collect()
}

/// So many digits, as times like 0.30000000000000004 are called 0.3.
fn round(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// The label of a tick of an axis of this span: what is left of zero where steps are added up is zero.
fn label(value: f64, span: f64) -> String {
    if value.abs() < 1e-9 * span { "0".into() } else { round(value, 6).to_string() }
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

type Fault = Box<dyn std::error::Error>;

fn draw(axes: &[String; 2], curves: &[Curve]) -> Result<String, Fault> {
    let mut svg = String::new();
    draw_in(&mut svg, axes, curves)?;
    // In millimetres, so that it is a column wide wherever it is placed.
    let pixels = format!("width=\"{}\" height=\"{}\"", SIDES.0 * POINT, SIDES.1 * POINT);
    let [wide, high] = [SIDES.0, SIDES.1].map(|points| f64::from(points) * 25.4 / 72.0);
    Ok(svg.replacen(&pixels, &format!("width=\"{wide:.1}mm\" height=\"{high:.1}mm\""), 1))
}

fn draw_in(svg: &mut String, [x_name, y_name]: &[String; 2], curves: &[Curve]) -> Result<(), Fault> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let (x_low, x_high) = range(points().map(|point| point.x));
    // Errors of pale points do not decide the picture. Zero belongs to it where it is not far.
    let sure = |point: &&Point| !point.noisy;
    let ends = |point: &Point| [point.y - point.error, point.y + point.error];
    let (y_low, y_high) = range(points().map(|point| point.y).chain(points().filter(sure).flat_map(ends)));
    let y_low = if y_low > 0.0 && y_low < 0.5 * y_high { 0.0 } else { y_low };

    let area = SVGBackend::with_string(svg, (SIDES.0 * POINT, SIDES.1 * POINT)).into_drawing_area();
    area.fill(&WHITE)?;
    let names = names(curves);
    let (head, rest) = area.split_vertically(names.len() as u32 * (TEXT + TEXT / 4));
    for (row, entries) in names.iter().enumerate() {
        let wide = (SIDES.0 * POINT) as i32 / entries.len().max(1) as i32;
        for (k, (name, colour)) in entries.iter().enumerate() {
            let (x, y) = (wide * k as i32 + POINT as i32 * 3, (row as u32 * (TEXT + TEXT / 4) + TEXT * 3 / 4) as i32);
            if let Some(colour) = colour {
                head.draw(&PathElement::new([(x, y), (x + SAMPLE, y)], colour.stroke_width(LINE)))?;
            }
            let style = ("sans-serif", TEXT).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
            head.draw(&Text::new(name.clone(), (x + SAMPLE + 8, y), style))?;
        }
    }
    let mut chart = ChartBuilder::on(&rest)
        .margin(3 * POINT)
        .x_label_area_size(TEXT * 5 / 2)
        .y_label_area_size(TEXT * 4)
        .build_cartesian_2d(x_low..x_high, y_low..y_high + 0.05 * (y_high - y_low))?;
    let tick = |span: f64| move |value: &f64| label(*value, span);
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(BLACK.stroke_width(AXIS))
        .label_style(("sans-serif", TEXT))
        .x_labels(5)
        .y_labels(5)
        .x_desc(x_name)
        .y_desc(y_name)
        .x_label_formatter(&tick(x_high - x_low))
        .y_label_formatter(&tick(y_high - y_low))
        .draw()?;
    curves.iter().try_for_each(|curve| draw_curve(&mut chart, curve))?;
    area.present()?;
    Ok(())
}

/// The band of errors, then the curve, pale where it is worth little. A point alone is a dot.
fn draw_curve(chart: &mut Chart<'_, '_>, curve: &Curve) -> Result<(), Fault> {
    let (points, colour) = (&curve.points, curve.colour);
    let at = |point: &Point| (point.x, point.y);
    for pair in points.windows(2).filter(|pair| pair.iter().any(|point| point.error > 0.0)) {
        let [a, b] = [pair[0], pair[1]];
        let corners = [(a.x, a.y - a.error), (b.x, b.y - b.error), (b.x, b.y + b.error), (a.x, a.y + a.error)];
        chart.draw_series([Polygon::new(corners, colour.mix(BAND))])?;
    }
    // Runs of points that are drawn alike; each begins with the last point of the one before.
    let mut first = 0;
    while first + 1 < points.len() {
        let noisy = |k: usize| points[k].noisy || points[k + 1].noisy;
        let last = (first + 1..points.len() - 1).find(|k| noisy(*k) != noisy(first)).unwrap_or(points.len() - 1);
        let style = if noisy(first) { colour.mix(PALE).stroke_width(LINE / 2) } else { colour.stroke_width(LINE) };
        chart.draw_series([PathElement::new(points[first..=last].iter().map(at).collect::<Vec<_>>(), style)])?;
        first = last;
    }
    if let [point] = points.as_slice() {
        chart.draw_series([Circle::new(at(point), LINE, colour.filled())])?;
    }
    Ok(())
}

/// The names over the axes in rows, as many in a row as fit; none of a single number, which the axis names.
fn names(curves: &[Curve]) -> Vec<Vec<(String, Option<RGBColor>)>> {
    let mut entries: Vec<(String, Option<RGBColor>)> = Vec::new();
    if curves.len() > 1 || curves.iter().any(|curve| curve.name.starts_with("t =")) {
        entries.extend(curves.iter().map(|curve| (curve.name.clone(), Some(curve.colour))));
    }
    let longest = entries.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let wide = f64::from(SAMPLE + 24) + LETTER * f64::from(TEXT) * longest as f64;
    let in_a_row = (f64::from(SIDES.0 * POINT) / wide).floor().max(1.0) as usize;
    let mut rows: Vec<_> = entries.chunks(in_a_row).map(<[_]>::to_vec).collect();
    if curves.iter().any(|curve| curve.points.iter().any(|point| point.noisy)) {
        rows.push(vec![(format!("pale: fewer than {FEW} counted; bands: standard errors"), None)]);
    }
    rows
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
        let svg = draw(&axes, &[curve(vec![point(0.0, false), point(1.0, false), point(2.0, true)])]).unwrap();
        assert!(svg.contains("pale: fewer than 30") && svg.matches("<polygon").count() == 2, "{svg}");
        assert!(svg.contains("width=\"86.1mm\"") && svg.contains("font-size=\"32"), "{svg}");
        assert!(draw(&axes, &[curve(vec![point(1.0, false)])]).unwrap().contains("<circle"));
    }
}
