//! Error over work, and the paths.

use super::targets::of;
use super::{Row, Run, Scheme, Side, Study};
use crate::StudyError;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;

/// Time between the points of a drawn path.
const DRAWN: f64 = 0.4;

/// Error over wall time and over products, both logarithmic.
pub(super) fn work(study: &Study) -> Result<Figure, StudyError> {
    let rows = study.rows();
    let curve = |side: Side, scheme: Scheme, work: fn(&Row) -> f64| Curve {
        name: match scheme {
            Scheme::Multisphere => format!("{}, dt {}", scheme.name(), study.size().multisphere_dt),
            _ => scheme.name().into(),
        },
        points: of(&rows, side, scheme).into_iter().map(|row| (work(row), row.worst)).collect(),
        marked: true,
    };
    let panel = |side: Side, title: &str, name: &'static str, work: fn(&Row) -> f64| Panel {
        title: format!("{}: {title}", side.name()),
        axes: [Axis { name, logarithmic: true }, Axis { name: "largest error of x, y, angle", logarithmic: true }],
        curves: [Scheme::Euler, Scheme::Midpoint, Scheme::Multisphere]
            .map(|scheme| curve(side, scheme, work))
            .into_iter()
            .filter(|curve| !curve.points.is_empty())
            .collect(),
        guides: Vec::new(),
    };
    let panels = [Side::Right, Side::Left].map(|side| {
        vec![
            panel(side, "over wall time", "milliseconds of all steps", |row| row.milliseconds),
            panel(side, "over products", "products with A of all steps", |row| row.products as f64),
        ]
    });
    draw("Two ellipsoids: error over work", &panels)
}

/// x, y and angle over time: the paper's steps, midpoint steps and sub-spheres below each other, for both sides.
pub(super) fn paths(study: &Study) -> Result<Figure, StudyError> {
    let row = |side: Side, scheme: Scheme| {
        let own = |run: &&Run| (run.case.side, run.case.scheme) == (side, scheme);
        let runs: Vec<&Run> = study.runs().iter().filter(own).collect();
        ["x", "y", "angle, radians"]
            .into_iter()
            .enumerate()
            .map(|(i, name)| panel(study, &runs, (side, scheme), i, name))
            .collect::<Vec<Panel>>()
    };
    let right = [Scheme::Euler, Scheme::Midpoint, Scheme::Multisphere].map(|scheme| row(Side::Right, scheme));
    let left = [Scheme::Euler, Scheme::Multisphere].map(|scheme| row(Side::Left, scheme));
    draw("Two ellipsoids: the upper body", &right.into_iter().chain(left).collect::<Vec<_>>())
}

fn panel(study: &Study, runs: &[&Run], of: (Side, Scheme), quantity: usize, name: &'static str) -> Panel {
    let (side, scheme) = of;
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
    curves.push(curve("reference".into(), &study.reference(side).path));
    Panel {
        title: format!("{}: {}: {name}", side.name(), scheme.name()),
        axes: [Axis { name: "time", logarithmic: false }, Axis { name, logarithmic: false }],
        curves,
        guides: Vec::new(),
    }
}
