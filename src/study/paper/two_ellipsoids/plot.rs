//! Error over work, and the paths.

use super::targets::of;
use super::{Row, Run, Scheme, Study};
use crate::study::StudyError;
use crate::study::plot::{Axis, Curve, Panel, draw};
use plotters::prelude::SeriesLabelPosition;

/// Time between the points of a drawn path.
const DRAWN: f64 = 0.4;

/// Error over wall time and over products, both logarithmic.
pub(super) fn work(study: &Study) -> Result<String, StudyError> {
    let rows = study.rows();
    let curve = |scheme: Scheme, work: fn(&Row) -> f64| Curve {
        name: match scheme {
            Scheme::Multisphere => format!("{}, dt {}", scheme.name(), study.size().multisphere_dt),
            _ => scheme.name().into(),
        },
        points: of(&rows, scheme).into_iter().map(|row| (work(row), row.worst)).collect(),
        marked: true,
    };
    let panel = |title: &str, name: &'static str, work: fn(&Row) -> f64| Panel {
        title: title.into(),
        axes: [Axis { name, logarithmic: true }, Axis { name: "largest error of x, y, angle", logarithmic: true }],
        curves: [Scheme::Euler, Scheme::Midpoint, Scheme::Multisphere].map(|scheme| curve(scheme, work)).into(),
        names: Some(SeriesLabelPosition::LowerLeft),
    };
    let time = panel("over wall time", "milliseconds of all steps", |row| row.milliseconds);
    let products = panel("over products", "products with A of all steps", |row| row.products as f64);
    draw("Two ellipsoids: error over work", &[vec![time, products]])
}

/// x, y and angle over time: the paper's steps, midpoint steps and sub-spheres below each other.
pub(super) fn paths(study: &Study) -> Result<String, StudyError> {
    let row = |scheme: Scheme| {
        let runs: Vec<&Run> = study.runs().iter().filter(|run| run.case.scheme == scheme).collect();
        ["x", "y", "angle, radians"]
            .into_iter()
            .enumerate()
            .map(|(i, name)| panel(study, &runs, scheme, i, name))
            .collect::<Vec<Panel>>()
    };
    draw("Two ellipsoids: the upper body", &[row(Scheme::Euler), row(Scheme::Midpoint), row(Scheme::Multisphere)])
}

fn panel(study: &Study, runs: &[&Run], scheme: Scheme, quantity: usize, name: &'static str) -> Panel {
    let curve = |name: String, path: &super::Path| {
        let path = path.every(DRAWN);
        let samples = path.samples[quantity].iter().enumerate();
        Curve { name, points: samples.map(|(k, value)| (k as f64 * path.interval, *value)).collect(), marked: false }
    };
    let name_of = |run: &Run| match run.case.spheres {
        Some(count) => format!("{count} spheres"),
        None => format!("dt {}", run.case.dt),
    };
    let mut curves: Vec<Curve> = runs.iter().map(|run| curve(name_of(run), &run.path)).collect();
    curves.push(curve("reference".into(), &study.reference().path));
    Panel {
        title: format!("{}: {name}", scheme.name()),
        axes: [Axis { name: "time", logarithmic: false }, Axis { name, logarithmic: false }],
        curves,
        names: (quantity == 0).then_some(SeriesLabelPosition::UpperLeft),
    }
}
