//! Overlap over the time of a step, and both over time.

use super::{Run, Study};
use crate::StudyError;
use crate::paper::Window;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;

/// The smallest value that is drawn. It replaces smaller values, and zero, which has no logarithm.
const FLOOR: f64 = 1e-9;

pub(super) fn plot(study: &Study) -> Result<Figure, StudyError> {
    let over_time = |name: &'static str, logarithmic: bool, of: fn(&Window) -> f64| Panel {
        title: "over time".into(),
        axes: [Axis { name: "time", logarithmic: false }, Axis { name, logarithmic }],
        curves: study.runs().iter().map(|run| curve(run, of)).collect(),
        guides: Vec::new(),
    };
    let steps = over_time("milliseconds a step", true, |window| window.milliseconds);
    let overlap = over_time("largest overlap (1e-9: that or less)", true, |window| window.max_overlap.max(FLOOR));
    draw("Packing", &[vec![beside(study), steps, overlap]])
}

fn curve(run: &Run, of: fn(&Window) -> f64) -> Curve {
    let points = run.summary.windows.iter().map(|window| (window.time, of(window)));
    Curve { name: name(run), points: points.collect(), marked: false }
}

fn name(run: &Run) -> String {
    format!("{} rods, dt {}", run.summary.bodies, run.summary.dt)
}

/// Overlap over time of a step, ours and the engines'.
fn beside(study: &Study) -> Panel {
    let ours = study.runs().iter().map(|run| Curve {
        name: name(run),
        points: vec![(run.summary.step_milliseconds(), run.summary.max_overlap.max(FLOOR))],
        marked: true,
    });
    let theirs = study.engines().iter().filter_map(|engine| {
        let (milliseconds, overlap) = engine.cost()?;
        let name = format!("{}, dt {}", engine.name(), engine.dt);
        (!engine.is_ours()).then(|| Curve { name, points: vec![(milliseconds, overlap.max(FLOOR))], marked: true })
    });
    Panel {
        title: "engines: 1,000 rods".into(),
        axes: [
            Axis { name: "processor's milliseconds a step", logarithmic: true },
            Axis { name: "largest overlap, a length", logarithmic: true },
        ],
        curves: ours.chain(theirs).collect(),
        guides: Vec::new(),
    }
}
