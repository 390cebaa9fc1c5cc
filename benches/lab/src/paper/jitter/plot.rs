//! Overlap and jitter over time.

use super::{Capsules, Method, Run, Study, Window};
use crate::StudyError;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;

/// What is drawn in place of anything smaller, zero too: a logarithm has no place for it.
const FLOOR: f64 = 1e-9;

/// Overlaps above, jitter below; the capsules that are left alone to the left, those that are pressed to the right.
pub(super) fn plot(study: &Study) -> Result<Figure, StudyError> {
    let row = |name: &'static str, of: fn(&Window) -> Option<f64>| {
        [Capsules::Alone, Capsules::Pressed].map(|capsules| panel(study, capsules, name, of)).into()
    };
    let overlap = row("largest overlap, a length (1e-9: that or less)", |window| Some(window.max_overlap));
    let jitter = row("jitter, a length (1e-9: that or less)", |window| window.jitter);
    draw("Three capsules", &[overlap, jitter])
}

fn panel(study: &Study, capsules: Capsules, name: &'static str, of: fn(&Window) -> Option<f64>) -> Panel {
    let alone = capsules == Capsules::Alone;
    // By step where dt does not matter.
    let at = |window: &Window| if alone { window.step as f64 } else { window.time };
    let curve = |run: &Run| {
        let point = |window: &Window| Some((at(window), of(window)?.max(FLOOR)));
        Curve {
            name: format!("{}, dt {:e}", run.case.method.name(), run.case.dt),
            points: run.windows.iter().filter_map(point).collect(),
            marked: false,
        }
    };
    let of_method = |method: Method| {
        let runs = study.runs().iter().filter(move |run| run.case.capsules == capsules && run.case.method == method);
        runs.map(curve)
    };
    Panel {
        title: capsules.name().into(),
        axes: [
            Axis { name: if alone { "step" } else { "time" }, logarithmic: false },
            Axis { name, logarithmic: true },
        ],
        curves: of_method(Method::Relcp).chain(of_method(Method::Snsd)).collect(),
        guides: Vec::new(),
    }
}
