//! Panels of curves one below the other, with one axis across. Each curve is named at its end.

use super::FEW;
use super::words::{Quantity, named};
use crate::figure::Figure;
use crate::figure::backend::Sheet;
use crate::figure::drawing::{self, Area, COLUMN, DOT, Failed, LINE, MARGIN, POINT, TEXT, X_LABELS};
use crate::figure::ends;
use crate::figure::head::{Head, Name};
use plotters::chart::ChartContext;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The height of a panel alone and of one of several, with the row of its name and without the numbers below it.
const ALONE: u32 = (COLUMN * 3 / 4) * POINT - X_LABELS;
const ONE_OF_SEVERAL: u32 = 104 * POINT;
/// The row of a panel's name over its axes.
const NAME_ROW: u32 = TEXT * 3 / 2;
/// Room for the numbers beside the vertical axis.
const NUMBERS: u32 = TEXT * 7 / 2;
/// Room over the highest point, as a part of the range.
const ABOVE: f64 = 0.05;
/// Numbers on an axis have so many digits before or after the point at the most, or a power of ten in its name.
const PLAIN_POWERS: std::ops::Range<i32> = -3..5;
/// The opacities of a band of errors, and of the pale part of a curve.
const BAND: f64 = 0.25;
const PALE: f64 = 0.35;
/// Names are so much of their curve's colour, the rest black: thin letters look paler than lines.
const LETTERS: f64 = 0.75;

/// A point of a curve: its position, its error, and whether it is noisy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub x: f64,
    pub y: f64,
    pub error: f64,
    pub noisy: bool,
}

/// Its name, empty where the panel's says it; its points and its colour.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub name: String,
    pub points: Vec<Point>,
    pub colour: RGBColor,
}

/// Curves of one quantity.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub quantity: Quantity,
    pub curves: Vec<Curve>,
}

type Chart<'a, 'b> = ChartContext<'a, Sheet<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// What all panels of a figure share.
struct Shared<'a, 'b> {
    page: &'a Area<'b>,
    planar: bool,
    /// Numbers on an axis.
    ticks: usize,
    across: (f64, f64),
    /// Room for names at the right.
    right: u32,
}

/// Draws panels, with `across` along the lowest axis.
pub(super) fn draw(title: &str, across: Quantity, panels: &[Panel], planar: bool) -> Result<Figure, Failed> {
    let head = Head::new(COLUMN * POINT, "", remarks(panels));
    let own = if panels.len() > 1 { ONE_OF_SEVERAL } else { ALONE };
    let high = (head.height() + own * panels.len() as u32 + X_LABELS).div_ceil(POINT);
    let curves = || panels.iter().flat_map(|panel| &panel.curves);
    let shared_range = range(curves().flat_map(|curve| &curve.points).map(|point| point.x));
    // A curve that ends before the others has its name among them.
    let at_edge = |curve: &&Curve| curve.points.last().is_some_and(|point| point.x >= near_end(shared_range));
    let wide = curves().filter(at_edge).map(|curve| ends::width(&curve.name)).max().unwrap_or(0);
    let right = if wide > 0 { wide + ends::GAP as u32 } else { 0 };
    drawing::draw(title, [COLUMN, high], |page| {
        let shared = Shared { page, planar, ticks: if panels.len() > 1 { 3 } else { 5 }, across: shared_range, right };
        let mut rest = head.draw(page, head.height())?;
        for (k, panel) in panels.iter().enumerate() {
            let below = k + 1 < panels.len();
            let (area, others) = rest.split_vertically(own + if below { 0 } else { X_LABELS });
            panel.draw(&area, &shared, (!below).then_some(across))?;
            rest = others;
        }
        Ok(())
    })
}

/// From here on a curve ends at the edge: its name does not reach back over more than the margin beside it.
fn near_end((low, high): (f64, f64)) -> f64 {
    high - 0.1 * (high - low)
}

impl Panel {
    /// With the numbers of the axis across below it where it is named.
    fn draw(&self, area: &Area<'_>, shared: &Shared<'_, '_>, across: Option<Quantity>) -> Result<(), Failed> {
        let (y_low, y_high) = self.heights();
        let (x_power, y_power) = (power(shared.across), power((y_low, y_high)));
        let (top, axes_area) = area.split_vertically(NAME_ROW);
        let style = ("sans-serif", TEXT).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
        let name = named(self.quantity, y_power, shared.planar);
        top.draw(&Text::new(name, (MARGIN as i32, NAME_ROW as i32 / 2), style))?;
        let mut chart = ChartBuilder::on(&axes_area)
            .margin(MARGIN)
            .margin_top(0)
            .margin_bottom(if across.is_some() { MARGIN } else { 0 })
            .margin_right(MARGIN + shared.right)
            .x_label_area_size(if across.is_some() { X_LABELS } else { MARGIN })
            .y_label_area_size(NUMBERS)
            .build_cartesian_2d(shared.across.0..shared.across.1, y_low..y_high)?;
        let numbers = across.is_some();
        let tick = |(low, high): (f64, f64), power: i32, shown: bool| {
            let unit = 10f64.powi(power);
            move |value: &f64| if shown { drawing::tick(*value / unit, (high - low) / unit) } else { String::new() }
        };
        let mut axes = chart.configure_mesh();
        drawing::style(&mut axes);
        axes.x_labels(5)
            .y_labels(shared.ticks)
            .x_desc(across.map(|quantity| named(quantity, x_power, shared.planar)).unwrap_or_default())
            .x_label_formatter(&tick(shared.across, x_power, numbers))
            .y_label_formatter(&tick((y_low, y_high), y_power, true))
            .draw()?;
        self.curves.iter().try_for_each(|curve| draw_curve(&mut chart, curve))?;
        self.name_curves(&chart, shared)
    }

    fn name_curves(&self, chart: &Chart<'_, '_>, shared: &Shared<'_, '_>) -> Result<(), Failed> {
        let on_page = |point: &Point| chart.backend_coord(&(point.x, point.y));
        let lines: Vec<Vec<_>> = self.curves.iter().map(|curve| curve.points.iter().map(on_page).collect()).collect();
        let names: Vec<&str> = self.curves.iter().map(|curve| curve.name.as_str()).collect();
        let (across, up) = chart.plotting_area().get_pixel_range();
        let half = TEXT as i32 / 2;
        let room = [across.start + half, up.start - half, across.end + (shared.right + MARGIN) as i32, up.end];
        for ((place, name), curve) in ends::places(&names, &lines, room).into_iter().zip(names).zip(&self.curves) {
            let Some(place) = place else { continue };
            let RGBColor(r, g, b) = curve.colour;
            let [r, g, b] = [r, g, b].map(|part| (f64::from(part) * LETTERS) as u8);
            let style =
                ("sans-serif", TEXT).into_font().color(&RGBColor(r, g, b)).pos(Pos::new(HPos::Left, VPos::Center));
            shared.page.draw(&Text::new(name.to_owned(), place, style))?;
        }
        Ok(())
    }

    /// The ends of the vertical axis: errors of pale points do not affect them, and zero is included if it is near.
    fn heights(&self) -> (f64, f64) {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let sure = |point: &&Point| !point.noisy;
        let both = |point: &Point| [point.y - point.error, point.y + point.error];
        let (low, high) = range(points().map(|point| point.y).chain(points().filter(sure).flat_map(both)));
        let low = if low > 0.0 && low < 0.5 * high { 0.0 } else { low };
        (low, high + ABOVE * (high - low))
    }
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

/// The power of ten in the name of an axis, a multiple of three.
fn power((low, high): (f64, f64)) -> i32 {
    let most = low.abs().max(high.abs());
    let power = most.log10().floor();
    if most == 0.0 || !power.is_finite() || PLAIN_POWERS.contains(&(power as i32)) {
        0
    } else {
        3 * (power / 3.0).floor() as i32
    }
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

/// The explanations above the panels.
fn remarks(panels: &[Panel]) -> Vec<Name> {
    let mut points = panels.iter().flat_map(|panel| &panel.curves).flat_map(|curve| &curve.points);
    let text = format!("Pale: fewer than {FEW} counted. Bands: standard errors.");
    points.any(|point| point.noisy).then_some(Name { text, colour: None }).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::super::words;
    use super::*;

    fn curve(name: &str, points: Vec<Point>) -> Curve {
        Curve { name: name.into(), points, colour: BLACK }
    }

    fn point(x: f64, y: f64, noisy: bool) -> Point {
        Point { x, y, error: 0.1, noisy }
    }

    #[test]
    fn few_counts_are_pale_with_bands_and_a_point_alone_is_a_dot() {
        let [across, up] = words::of_profile("correlation");
        let draw =
            |points| draw("correlation", across, &[Panel { quantity: up, curves: vec![curve("t = 1", points)] }], true);
        let svg = draw(vec![point(0.0, 1.0, false), point(1.0, 2.0, false), point(2.0, 3.0, true)]).unwrap().svg();
        let [band, pale] =
            ["fill=\"#000000\" fill-opacity=\"0.25\"", "stroke-opacity=\"0.35\""].map(|ink| svg.matches(ink).count());
        assert!(svg.contains("Pale: fewer than 30") && band == 1 && pale == 1, "{svg}");
        assert!(svg.contains("width=\"86.08mm\"") && svg.contains("font-size=\"80\""), "{svg}");
        assert!(svg.contains(">t = 1<") && svg.contains(">Distance (length)<"), "{svg}");
        // A dot has arcs; the ticks and lines of the axes have none.
        assert!(!svg.contains('Q') && draw(vec![point(1.0, 2.0, false)]).unwrap().svg().contains('Q'));
    }

    #[test]
    fn quantities_have_a_panel_each_below_each_other_with_one_axis_across() {
        let exact = |x: f64, y: f64| Point { error: 0.0, ..point(x, y, false) };
        let two = |scale: f64| vec![exact(0.0, scale), exact(2.0, 3.0 * scale)];
        let [radius, rate] = ["radius_gyration", "expansion_rate"].map(|column| words::of_column(column).0);
        let panels = [
            Panel { quantity: radius, curves: vec![curve("gyration", two(1.0)), curve("outermost", two(1.1))] },
            Panel { quantity: rate, curves: vec![curve("", two(1e-7))] },
        ];
        let svg = draw("radius", words::OVER_TIME, &panels, true).unwrap().svg();
        for text in [">Radius (length)<", ">Expansion rate (10⁻⁹ length per time)<", ">gyration<", ">outermost<"] {
            assert_eq!(svg.matches(text).count(), 1, "{text}: {svg}");
        }
        assert_eq!((svg.matches(">Time<").count(), svg.matches(">0.5<").count()), (1, 1), "{svg}");
        let high = (2 * ONE_OF_SEVERAL + X_LABELS + MARGIN / 2).div_ceil(POINT) * POINT;
        assert!(svg.contains(&format!("viewBox=\"0 0 2440 {high}\"")), "{svg}");
    }

    #[test]
    fn axes_have_short_numbers() {
        assert_eq!([(0.0, 1e-3), (0.0, 9.9e-4), (-2e5, 1.0), (0.0, 0.0), (1.0, 99_999.0)].map(power), [0, -6, 3, 0, 0]);
    }
}
