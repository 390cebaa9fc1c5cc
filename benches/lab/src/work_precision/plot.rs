//! Error over wall time, over products and over the overlap tolerance.

use super::best::curves;
use super::case::{Row, Sweep};
use super::problem::Problem;
use super::reference::Reference;
use crate::StudyError;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;

/// The panels of a scene.
pub(super) fn plot(problem: &Problem, reference: &Reference, rows: &[&Row]) -> Result<Figure, StudyError> {
    let panel = |title: &str, name: &'static str, shows: fn(&Row) -> bool, work: fn(&Row) -> f64| {
        let shown = rows.iter().copied().filter(|row| shows(row));
        let mut drawn: Vec<Curve> = curves(shown)
            .into_iter()
            .map(|curve| Curve {
                points: curve.rows.iter().filter_map(|row| Some((work(row), row.error?))).collect(),
                name: curve.name,
                marked: true,
            })
            .collect();
        let works = || drawn.iter().flat_map(|curve| curve.points.iter().map(|(work, _)| *work));
        let (low, high) = (works().fold(f64::INFINITY, f64::min), works().fold(0.0, f64::max));
        if low <= high {
            let own = reference.estimate.worst();
            let points = vec![(low, own), (high, own)];
            drawn.push(Curve { name: "the reference's own error".into(), points, marked: false });
        }
        Panel {
            title: title.into(),
            axes: [Axis { name, logarithmic: true }, Axis { name: "error at the end", logarithmic: true }],
            curves: drawn,
            guides: Vec::new(),
        }
    };
    let refined: fn(&Row) -> bool = |row| row.sweep != Sweep::Tolerance;
    let time = panel("over wall time", "milliseconds of all steps", refined, |row| 1e3 * row.wall_seconds);
    let products = panel("over products", "products with A of all steps", refined, |row| row.products as f64);
    let swept: fn(&Row) -> bool = |row| row.sweep == Sweep::Tolerance;
    let tolerance = panel("over the overlap tolerance", "overlap tolerance", swept, |row| row.overlap_tolerance);
    draw(&format!("{}: work and precision", problem.name), &[vec![time, products, tolerance]])
}
