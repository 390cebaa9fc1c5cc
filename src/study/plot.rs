//! Curves in panels side by side and below each other, as SVG.

use super::StudyError;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::coord::{Shift, types::RangedCoordf64};
use plotters::prelude::*;
use std::ops::Range;

/// Colours that stay apart for most eyes (Okabe and Ito 2008), for as many curves as there may be in turn.
pub(super) const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(150, 150, 0),
];

/// Pixels of a panel.
const PANEL: (u32, u32) = (560, 420);

/// Pixels of the title.
const TITLE: u32 = 30;

/// How far a logarithmic axis goes beyond the curves, a factor; a linear one goes beyond them by this part of its
/// length.
const MARGIN: f64 = 1.5;
const LINEAR_MARGIN: f64 = 0.04;

type Failed = Box<dyn std::error::Error>;

/// A named curve.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
    /// Whether its points are marked.
    pub(super) marked: bool,
}

/// What an axis shows, and whether it is logarithmic.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) name: &'static str,
    pub(super) logarithmic: bool,
}

/// A panel of a plot.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub(super) title: String,
    pub(super) axes: [Axis; 2],
    pub(super) curves: Vec<Curve>,
    /// Where the names of the curves are written, if they are.
    pub(super) names: Option<SeriesLabelPosition>,
}

/// Draws rows of panels, each row as long as the first. Points that a logarithmic axis does not have are left out.
pub(super) fn draw(title: &str, rows: &[Vec<Panel>]) -> Result<String, StudyError> {
    let mut out = String::new();
    draw_in(title, rows, &mut out).map_err(|fault| StudyError::Plot(fault.to_string()))?;
    Ok(out)
}

fn draw_in(title: &str, rows: &[Vec<Panel>], out: &mut String) -> Result<(), Failed> {
    let columns = rows.first().map_or(1, Vec::len).max(1);
    let count = |n: usize| u32::try_from(n).unwrap_or(1);
    let size = (PANEL.0 * count(columns), PANEL.1 * count(rows.len().max(1)) + TITLE);
    let area = SVGBackend::with_string(out, size).into_drawing_area();
    area.fill(&WHITE)?;
    let area = area.titled(title, ("sans-serif", 20))?;
    let areas = area.split_evenly((rows.len().max(1), columns));
    for (area, panel) in areas.iter().zip(rows.iter().flatten()) {
        let [x, y] = panel.ranges();
        match panel.axes.each_ref().map(|axis| axis.logarithmic) {
            [false, false] => fill(area, panel, linear(x), linear(y))?,
            [false, true] => fill(area, panel, linear(x), y.log_scale())?,
            [true, false] => fill(area, panel, x.log_scale(), linear(y))?,
            [true, true] => fill(area, panel, x.log_scale(), y.log_scale())?,
        }
    }
    area.present()?;
    Ok(())
}

fn linear(range: Range<f64>) -> RangedCoordf64 {
    range.into()
}

impl Panel {
    fn shows(&self, (x, y): (f64, f64)) -> bool {
        let has = |axis: &Axis, v: f64| v.is_finite() && (v > 0.0 || !axis.logarithmic);
        has(&self.axes[0], x) && has(&self.axes[1], y)
    }

    fn ranges(&self) -> [Range<f64>; 2] {
        let points = || self.curves.iter().flat_map(|curve| &curve.points).filter(|point| self.shows(**point));
        let x = self.axes[0].range(points().map(|point| point.0));
        [x, self.axes[1].range(points().map(|point| point.1))]
    }
}

impl Axis {
    /// The range of values and some more; where there is none, one that can be drawn.
    fn range(&self, values: impl Iterator<Item = f64>) -> Range<f64> {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        match (high >= low, self.logarithmic) {
            (true, true) => low / MARGIN..high * MARGIN,
            (true, false) if high > low => {
                let margin = LINEAR_MARGIN * (high - low);
                low - margin..high + margin
            }
            (true, false) => low - 1.0..high + 1.0,
            (false, true) => 0.1..10.0,
            (false, false) => 0.0..1.0,
        }
    }

    fn label(&self, value: f64) -> String {
        if self.logarithmic {
            format!("{value:.0e}")
        } else {
            // What is left of zero where steps are added up is zero.
            let short = format!("{value:.3}");
            let short = short.trim_end_matches('0').trim_end_matches('.');
            if short == "-0" { "0".into() } else { short.into() }
        }
    }
}

fn fill<X, Y>(area: &DrawingArea<SVGBackend<'_>, Shift>, panel: &Panel, x: X, y: Y) -> Result<(), Failed>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, ("sans-serif", 16))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(x, y)?;
    let [x_axis, y_axis] = &panel.axes;
    chart
        .configure_mesh()
        .x_desc(x_axis.name)
        .y_desc(y_axis.name)
        .x_label_formatter(&|value| x_axis.label(*value))
        .y_label_formatter(&|value| y_axis.label(*value))
        .x_labels(8)
        .light_line_style(WHITE)
        .max_light_lines(1)
        .draw()?;
    for (curve, colour) in panel.curves.iter().zip(COLOURS.iter().cycle()) {
        let style = colour.stroke_width(2);
        let points = curve.points.iter().copied().filter(|point| panel.shows(*point));
        let line = LineSeries::new(points, style).point_size(if curve.marked { 3 } else { 0 });
        let drawn = chart.draw_series(line)?;
        if panel.names.is_some() {
            drawn.label(&curve.name).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
    }
    if let Some(position) = &panel.names {
        chart
            .configure_series_labels()
            .position(position.clone())
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(points: Vec<(f64, f64)>, logarithmic: bool) -> Panel {
        let axis = |name| Axis { name, logarithmic };
        let curve = Curve { name: "one".into(), points, marked: true };
        Panel {
            title: "panel".into(),
            axes: [axis("x"), axis("y")],
            curves: vec![curve],
            names: Some(SeriesLabelPosition::LowerLeft),
        }
    }

    #[test]
    fn panels_without_points_and_with_points_that_have_no_logarithm_are_drawn() {
        let rows = [
            vec![panel(vec![], true), panel(vec![(1.0, 0.0), (2.0, 1e-3), (f64::NAN, 1.0)], true)],
            vec![panel(vec![], false), panel(vec![(1.0, 2.0)], false)],
        ];
        assert!(draw("title", &rows).unwrap().starts_with("<svg"));
        assert_eq!(rows[0][1].ranges()[0], 2.0 / MARGIN..2.0 * MARGIN);
    }

    #[test]
    fn ticks_are_short() {
        let [linear, logarithmic] = [false, true].map(|logarithmic| Axis { name: "", logarithmic });
        assert_eq!(linear.label(-1e-17), "0");
        assert_eq!((linear.label(0.30000000000000004), linear.label(40.0)), ("0.3".into(), "40".into()));
        assert_eq!(logarithmic.label(1e-5), "1e-5");
    }
}
