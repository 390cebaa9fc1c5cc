//! What figures are drawn with: sizes, colours and axes that all of them have.

use super::Figure;
use super::backend::Sheet;
use crate::page::Page;
use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;

/// Units of a page in a point.
pub const POINT: u32 = 10;
/// The width of a column in points, 86 mm: what most journals of this field have.
pub const COLUMN: u32 = 244;
/// The size of text: 8 points.
pub const TEXT: u32 = 8 * POINT;
/// The width of curves: 1.2 points.
pub const LINE: u32 = 12;
/// The width of axes and ticks: half a point.
pub const AXIS: u32 = 5;
/// The length of ticks.
pub const TICK: u32 = 25;
/// The radius of marks of points.
pub const DOT: u32 = 16;
/// Room beside a figure's edges.
pub const MARGIN: u32 = 4 * POINT;
/// Room for numbers and a name below the horizontal axis.
pub const X_LABELS: u32 = TEXT * 3;
/// Room for numbers and a name beside the vertical axis.
pub const Y_LABELS: u32 = TEXT * 9 / 2;

/// Colours of curves of different kinds.
pub const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(150, 150, 0),
];

/// What a drawing may fail with.
pub type Failed = Box<dyn std::error::Error>;

/// A place to draw on.
pub type Area<'a> = DrawingArea<Sheet<'a>, Shift>;

/// A figure of some points of width and height.
pub fn draw(
    title: &str,
    [wide, high]: [u32; 2],
    draw: impl FnOnce(&Area<'_>) -> Result<(), Failed>,
) -> Result<Figure, Failed> {
    let size = [wide * POINT, high * POINT];
    let mut page = Page::new(title, size.map(|side| side as f32), 1.0 / POINT as f32);
    let area = Sheet::on(&mut page).into_drawing_area();
    area.fill(&WHITE)?;
    draw(&area)?;
    area.present()?;
    drop(area);
    Ok(Figure(page))
}

/// The style of the axes of all figures: no grid, short ticks, text of one size.
pub fn style<X: Ranged, Y: Ranged, D: DrawingBackend>(axes: &mut MeshStyle<'_, '_, X, Y, D>) {
    axes.disable_mesh();
    axes.axis_style(BLACK.stroke_width(AXIS)).set_all_tick_mark_size(TICK).label_style(("sans-serif", TEXT));
}

/// The number beside a tick of a linear axis of this span: short, and what is left of zero where steps are added up is
/// zero.
pub fn tick(value: f64, span: f64) -> String {
    if value.abs() < 1e-9 * span { "0".into() } else { shortest(value, 6) }
}

/// So many digits, as times like 0.30000000000000004 are called 0.3.
pub fn shortest(value: f64, digits: usize) -> String {
    format!("{value:.*e}", digits - 1).parse::<f64>().unwrap_or(value).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        assert_eq!(tick(1.1102230246251565e-16, 1.8), "0");
        assert_eq!((tick(0.30000000000000004, 1.0), tick(-2e-7, 1e-6)), ("0.3".into(), "-0.0000002".into()));
    }

    #[test]
    fn a_figure_holds_what_is_drawn() {
        let drawn = draw("one", [100, 50], |area| {
            area.draw(&Circle::new((100, 100), 20, COLOURS[1].filled()))?;
            Ok(())
        });
        let svg = drawn.unwrap().svg();
        assert!(svg.contains("#d55e00") && svg.contains("viewBox=\"0 0 1000 500\""), "{svg}");
    }
}
