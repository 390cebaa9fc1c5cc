//! Residual over products, both logarithmic: cold starts to the left, warm ones to the right.

use super::{Curve, Instance, Start, TOLERANCES};
use crate::study::StudyError;
use crate::study::plot::COLOURS;
use plotters::prelude::*;

/// Pixels.
const SIZE: (u32, u32) = (1200, 520);

/// How far the axes go beyond the curves.
const MARGIN: f64 = 2.0;

/// A plot of the curves of an LCP, as SVG.
///
/// # Errors
/// [`StudyError::Plot`] where it cannot be drawn.
pub fn plot(instance: &Instance) -> Result<String, StudyError> {
    let mut out = String::new();
    draw(instance, &mut out).map_err(|fault| StudyError::Plot(fault.to_string()))?;
    Ok(out)
}

fn draw(instance: &Instance, out: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(out, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let title = format!("{}: {} rows, {} bodies", instance.lcp, instance.rows, instance.bodies);
    let area = area.titled(&title, ("sans-serif", 20))?;
    // Zero has no logarithm.
    let points = instance.curves.iter().flat_map(|curve| &curve.points).filter(|(_, residual)| *residual > 0.0);
    let (mut most, mut low, mut high) = (10.0_f64, TOLERANCES.into_iter().fold(1.0, f64::min), 0.0_f64);
    for (products, residual) in points {
        (most, low, high) = (most.max(*products as f64), low.min(*residual), high.max(*residual));
    }
    // Exact methods end far below what is asked for: the plot need not follow them all the way.
    let low = low.max(1e-2 * TOLERANCES.into_iter().fold(1.0, f64::min)) / MARGIN;
    let high = high.max(10.0 * low) * MARGIN;
    for (panel, start) in area.split_evenly((1, 2)).iter().zip(Start::BOTH) {
        let mut chart = ChartBuilder::on(panel)
            .caption(format!("{} start", start.name()), ("sans-serif", 16))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d((1.0..most * MARGIN).log_scale(), (low..high).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("products with A")
            .y_desc("smallest residual so far, a length")
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .light_line_style(WHITE)
            .draw()?;
        for tolerance in TOLERANCES {
            let line = [(1.0, tolerance), (most * MARGIN, tolerance)];
            chart.draw_series(LineSeries::new(line, BLACK.mix(0.4)))?;
        }
        for (curve, colour) in instance.curves.iter().filter(|curve| curve.start == start).zip(COLOURS.iter().cycle()) {
            let style = colour.stroke_width(2);
            chart
                .draw_series(LineSeries::new(drawn(curve, low), style))?
                .label(&curve.solver)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()?;
    }
    area.present()?;
    Ok(())
}

fn drawn(curve: &Curve, low: f64) -> Vec<(f64, f64)> {
    curve.points.iter().map(|(products, residual)| (products.max(&1).to_owned() as f64, residual.max(low))).collect()
}
