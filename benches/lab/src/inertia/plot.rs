//! What tops drift by, over the angle of a step.

use super::{SHAPES, STEPPINGS, Study, TopRow};
use crate::StudyError;
use crate::paper::COMPUTED_BY;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;

/// Changes below a rounding are drawn as one.
const LEAST: f64 = f64::EPSILON;

/// A panel a stepping for what tops keep of their energy on the CPU.
pub(super) fn plot(study: &Study) -> Result<Figure, StudyError> {
    let panel = |stepping| {
        let curve = |(top, _, _): &(&'static str, _, _)| {
            let of_top = |row: &&TopRow| row.top == *top && row.stepping == stepping && row.computed_by == COMPUTED_BY;
            let points = study.tops().iter().filter(of_top).map(|row| (row.angle, row.energy.max(LEAST)));
            Curve { name: (*top).into(), points: points.collect(), marked: true }
        };
        Panel {
            title: format!("{stepping:?} steps"),
            axes: [
                Axis { name: "angle a step, radians", logarithmic: true },
                Axis { name: "largest change of energy, a part of it", logarithmic: true },
            ],
            curves: SHAPES.iter().map(curve).collect(),
            guides: Vec::new(),
        }
    };
    draw("Tops that turn freely, by the CPU in f64", &[STEPPINGS.map(panel).to_vec()])
}
