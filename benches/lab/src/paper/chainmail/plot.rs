//! The largest violation over time, and how far the sheet reaches.

use super::{Run, Study};
use crate::StudyError;
use crate::paper::Window;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;

/// What is drawn in place of anything smaller, zero too: a logarithm has no place for it.
const FLOOR: f64 = 1e-9;

pub(super) fn plot(study: &Study) -> Result<Figure, StudyError> {
    let violations = study.runs().iter().flat_map(violations).collect();
    let extents = study.runs().iter().flat_map(|run| {
        [(0, "x"), (1, "y")].map(|(axis, name)| {
            let at = |(window, extent): (&Window, &super::Extent)| (window.time, extent[axis]);
            let points = run.summary.windows.iter().zip(&run.extents).map(at).collect();
            Curve { name: format!("{}, along {name}", run.summary.method), points, marked: false }
        })
    });
    let panel = |title: &str, name, logarithmic, curves| Panel {
        title: title.into(),
        axes: [Axis { name: "time", logarithmic: false }, Axis { name, logarithmic }],
        curves,
        guides: Vec::new(),
    };
    let overlap = "largest overlap of the steps, a length (1e-9: that or less)";
    let reach = "root mean square of the centres, a length";
    draw(
        "Chainmail",
        &[vec![
            panel("violation", overlap, true, violations),
            panel("extent of the sheet", reach, false, extents.collect()),
        ]],
    )
}

/// The overlap of smooth rings, and of sub-spheres where there are any.
fn violations(run: &Run) -> Vec<Curve> {
    let curve = |name: String, of: &dyn Fn(&Window) -> Option<f64>| {
        let point = |window: &Window| Some((window.time, of(window)?.max(FLOOR)));
        Curve { name, points: run.summary.windows.iter().filter_map(point).collect(), marked: false }
    };
    let method = &run.summary.method;
    let mut curves = vec![curve(method.clone(), &|window| Some(window.max_overlap))];
    if run.summary.proxy_overlap.is_some() {
        curves.push(curve(format!("{method}, its spheres"), &|window| window.proxy_overlap));
    }
    curves
}
