//! Residual over products, both logarithmic: cold starts to the left, warm ones to the right.

use super::{Curve, Instance, Start, TOLERANCES};
use crate::StudyError;
use crate::plot::{Axis, Curve as Drawn, Panel, draw};
use relcp::figure::Figure;

/// Exact methods end far below the tolerance: curves are drawn down to this fraction of the finest tolerance.
const LEAST: f64 = 1e-2;

/// The curves of an LCP, with the tolerances as grey lines.
///
/// # Errors
/// [`StudyError::Plot`] where they cannot be drawn.
pub fn plot(instance: &Instance) -> Result<Figure, StudyError> {
    let title = format!("{}: {} rows, {} bodies", instance.lcp, instance.rows, instance.bodies);
    let low = LEAST * TOLERANCES.into_iter().fold(1.0, f64::min);
    let panel = |start: Start| Panel {
        title: format!("{title}, {} start", start.name()),
        axes: [
            Axis { name: "products with A", logarithmic: true },
            Axis { name: "smallest residual so far (length)", logarithmic: true },
        ],
        curves: instance.curves.iter().filter(|curve| curve.start == start).map(|curve| drawn(curve, low)).collect(),
        guides: TOLERANCES.to_vec(),
    };
    draw(&title, &[Start::BOTH.map(panel).to_vec()])
}

fn drawn(curve: &Curve, low: f64) -> Drawn {
    // Zero products and a zero residual have no logarithm.
    let point = |(products, residual): &(u64, f64)| ((*products).max(1) as f64, residual.max(low));
    Drawn { name: curve.solver.clone(), points: curve.points.iter().map(point).collect(), marked: false }
}
