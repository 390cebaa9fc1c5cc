//! Time over that of ReLCP, and rows, over time; one line of panels per step, as in the paper's Figure 4.

use super::{Part, Run, Study};
use crate::StudyError;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;

pub(super) fn plot(study: &Study) -> Result<Figure, StudyError> {
    let rows: Vec<Vec<Panel>> = study.size().steps.iter().map(|(dt, _)| panels(study, *dt)).collect();
    draw("Compaction", &rows)
}

fn panels(study: &Study, dt: f64) -> Vec<Panel> {
    let whole = || study.runs().iter().filter(move |run| run.case.part == Part::Whole && run.case.dt == dt);
    let curve = |run: &Run, points: Vec<(f64, f64)>| Curve { name: run.summary.method.clone(), points, marked: false };
    let ratios = whole().filter(|run| !run.summary.is_relcp()).filter_map(|run| {
        let relcp = &study.relcp(&run.case)?.summary;
        let points = run.summary.beside(relcp).map(|(own, other)| (own.time, own.milliseconds / other.milliseconds));
        Some(curve(run, points.collect()))
    });
    let rows = whole()
        .map(|run| curve(run, run.summary.windows.iter().map(|window| (window.time, window.constraints)).collect()));
    let panel = |name, curves| Panel {
        title: format!("dt {dt}"),
        axes: [Axis { name: "time", logarithmic: false }, Axis { name, logarithmic: true }],
        curves,
        guides: Vec::new(),
    };
    vec![panel("time of a step over ReLCP's", ratios.collect()), panel("rows of a step", rows.collect())]
}
