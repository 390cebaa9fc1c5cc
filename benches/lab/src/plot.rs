//! Curves in a grid of panels.

use super::StudyError;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use relcp::figure::Figure;
use relcp::internals::figure::{
    self, AXIS, Area, COLOURS, COLUMN, DOT, Failed, Head, LINE, MARGIN, Name, POINT, X_LABELS, Y_LABELS,
};
use std::ops::Range;

/// The text width of a page in points, 178 mm, as in most journals of this field.
const TEXT_WIDTH: u32 = 505;

/// The ratio of height to width of a panel's axes, and their minimum height in narrow panels (points).
const ASPECT: f64 = 0.7;
const LEAST_HEIGHT: u32 = 150;

/// How far a logarithmic axis goes beyond the curves, a factor; a linear one goes beyond them by this part of its
/// length.
const MARGIN_FACTOR: f64 = 1.5;
const LINEAR_MARGIN: f64 = 0.04;

/// The opacity of guide lines.
const GUIDE: f64 = 0.3;

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

/// A panel of a figure.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub(super) title: String,
    pub(super) axes: [Axis; 2],
    pub(super) curves: Vec<Curve>,
    /// Heights of grey lines across it.
    pub(super) guides: Vec<f64>,
}

/// Draws rows of panels, each as long as the first. Points that a logarithmic axis cannot show are omitted.
pub(super) fn draw(title: &str, rows: &[Vec<Panel>]) -> Result<Figure, StudyError> {
    let columns = rows.first().map_or(1, Vec::len).max(1) as u32;
    let wide = if columns == 1 { COLUMN } else { TEXT_WIDTH };
    let own = wide / columns;
    let heads: Vec<RowHead> = rows.iter().map(|row| RowHead::new(row, wide * POINT)).collect();
    let axes = ((f64::from(own) * ASPECT) as u32).max(LEAST_HEIGHT);
    let high: u32 = heads.iter().map(|head| axes + head.height().div_ceil(POINT)).sum();
    let drawn = figure::draw(title, [wide, high.max(1)], |area| {
        let mut rest = area.clone();
        for (row, head) in rows.iter().zip(&heads) {
            let (own, below) = rest.split_vertically(head.height() + axes * POINT);
            let panels = head.names.draw(&own, head.names.height())?;
            for (area, panel) in panels.split_evenly((1, columns as usize)).iter().zip(row) {
                let heading = Head::new(area.dim_in_pixel().0, &panel.title, Vec::new());
                panel.draw(&heading.draw(area, head.heading)?, &head.order)?;
            }
            rest = below;
        }
        Ok(())
    });
    drawn.map_err(|fault| StudyError::Plot(fault.to_string()))
}

/// The legend over a row of panels: the names of all its curves, each once. A name has one colour in all panels.
struct RowHead {
    order: Vec<String>,
    names: Head,
    /// The height of the panels' own headings.
    heading: u32,
}

impl RowHead {
    fn new(row: &[Panel], wide: u32) -> Self {
        let mut order: Vec<String> = Vec::new();
        for curve in row.iter().flat_map(|panel| &panel.curves) {
            if !order.contains(&curve.name) {
                order.push(curve.name.clone());
            }
        }
        let names = order.iter().map(|name| Name { text: name.clone(), colour: Some(colour(&order, name)) });
        let heading = row.iter().map(|panel| Head::new(wide, &panel.title, Vec::new()).height()).max().unwrap_or(0);
        RowHead { names: Head::new(wide, "", names.collect()), order, heading }
    }

    fn height(&self) -> u32 {
        self.names.height() + self.heading
    }
}

/// Returns the colour of a name.
fn colour(order: &[String], name: &str) -> RGBColor {
    let at = order.iter().position(|own| own == name).unwrap_or(0);
    COLOURS[at % COLOURS.len()]
}

fn linear(range: Range<f64>) -> RangedCoordf64 {
    range.into()
}

impl Panel {
    fn draw(&self, area: &Area<'_>, order: &[String]) -> Result<(), Failed> {
        let [x, y] = self.ranges();
        match self.axes.each_ref().map(|axis| axis.logarithmic) {
            [false, false] => fill((area, self, order), linear(x), linear(y)),
            [false, true] => fill((area, self, order), linear(x), y.log_scale()),
            [true, false] => fill((area, self, order), x.log_scale(), linear(y)),
            [true, true] => fill((area, self, order), x.log_scale(), y.log_scale()),
        }
    }

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
    /// Returns the range of the values with a margin, or a default range that can be drawn if there are no values.
    fn range(&self, values: impl Iterator<Item = f64>) -> Range<f64> {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        match (high >= low, self.logarithmic) {
            (true, true) => low / MARGIN_FACTOR..high * MARGIN_FACTOR,
            (true, false) if high > low => {
                let margin = LINEAR_MARGIN * (high - low);
                low - margin..high + margin
            }
            (true, false) => low - 1.0..high + 1.0,
            (false, true) => 0.1..10.0,
            (false, false) => 0.0..1.0,
        }
    }

    fn label(&self, value: f64, range: &Range<f64>) -> String {
        if self.logarithmic { power(value) } else { figure::tick(value, range.end - range.start) }
    }
}

fn fill<X, Y>((area, panel, order): (&Area<'_>, &Panel, &[String]), x: X, y: Y) -> Result<(), Failed>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let [across, up] = panel.ranges();
    let mut chart = ChartBuilder::on(area)
        .margin(MARGIN)
        .x_label_area_size(X_LABELS)
        .y_label_area_size(Y_LABELS)
        .build_cartesian_2d(x, y)?;
    let [x_axis, y_axis] = &panel.axes;
    let mut axes = chart.configure_mesh();
    figure::style(&mut axes);
    axes.x_desc(x_axis.name)
        .y_desc(y_axis.name)
        .x_label_formatter(&|value| x_axis.label(*value, &across))
        .y_label_formatter(&|value| y_axis.label(*value, &up))
        .x_labels(5)
        .y_labels(6)
        .draw()?;
    for height in &panel.guides {
        let line = [(across.start, *height), (across.end, *height)];
        chart.draw_series([PathElement::new(line, BLACK.mix(GUIDE).stroke_width(AXIS))])?;
    }
    for curve in &panel.curves {
        let colour = colour(order, &curve.name);
        let points: Vec<_> = curve.points.iter().copied().filter(|point| panel.shows(*point)).collect();
        if curve.marked {
            chart.draw_series(points.iter().map(|point| Circle::new(*point, DOT, colour.filled())))?;
        }
        chart.draw_series([PathElement::new(points, colour.stroke_width(LINE))])?;
    }
    Ok(())
}

/// Returns the label of a tick of a logarithmic axis: a plain number if it is neither small nor large, otherwise a
/// power of ten.
fn power(value: f64) -> String {
    if (0.01..=1000.0).contains(&value) {
        return figure::shortest(value, 2);
    }
    let text = format!("{value:.0e}");
    match text.split_once('e') {
        Some(("1", exponent)) => format!("10{}", exponent.chars().map(raised).collect::<String>()),
        Some((digit, exponent)) => format!("{digit}·10{}", exponent.chars().map(raised).collect::<String>()),
        None => text,
    }
}

fn raised(digit: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    digit.to_digit(10).and_then(|digit| DIGITS.get(digit as usize).copied()).unwrap_or('⁻')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(points: Vec<(f64, f64)>, logarithmic: bool) -> Panel {
        let axis = |name| Axis { name, logarithmic };
        let curve = Curve { name: "one".into(), points, marked: true };
        Panel { title: "panel".into(), axes: [axis("x"), axis("y")], curves: vec![curve], guides: vec![2e-4] }
    }

    #[test]
    fn ticks_of_logarithmic_axes_are_powers_of_ten() {
        assert_eq!([1e-5, 1e4, 0.01, 100.0, 20.0, 2e-5].map(power), ["10⁻⁵", "10⁴", "0.01", "100", "20", "2·10⁻⁵"]);
    }

    #[test]
    fn panels_without_points_and_with_points_that_have_no_logarithm_are_drawn() {
        let rows = [
            vec![panel(vec![], true), panel(vec![(1.0, 0.0), (2.0, 1e-3), (f64::NAN, 1.0)], true)],
            vec![panel(vec![], false), panel(vec![(1.0, 2.0)], false)],
        ];
        let svg = draw("title", &rows).unwrap().svg();
        assert!(svg.contains("width=\"178.15mm\"") && svg.matches(">one<").count() == 2, "{svg}");
        assert_eq!(rows[0][1].ranges()[0], 2.0 / MARGIN_FACTOR..2.0 * MARGIN_FACTOR);
    }
}
