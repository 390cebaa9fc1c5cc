//! Time over that of ReLCP and rows over time, as in the paper's Figure 5; and the alignment of cells, by generation.

use super::{Morphology, Run, SHOWN, Study};
use crate::StudyError;
use crate::paper::method_name;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;
use relcp::scene::Method;

pub(super) fn plot(study: &Study) -> Result<Figure, StudyError> {
    let morphology = study.morphology();
    let of = |quantity: &'static str| aligned(&morphology, quantity);
    draw("Colony", &[vec![ratios(study), rows(study)], vec![of("correlation length"), of("local nematic order")]])
}

fn curve(run: &Run, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: run.summary.method.clone(), points, marked: false }
}

fn ratios(study: &Study) -> Panel {
    let relcp = study.first_runs().find(|run| run.summary.is_relcp());
    let of = |run: &Run| {
        let windows = run.summary.beside(&relcp?.summary);
        Some(curve(run, windows.map(|(own, other)| (own.time, own.milliseconds / other.milliseconds)).collect()))
    };
    let curves = study.first_runs().filter(|run| !run.summary.is_relcp()).filter_map(of).collect();
    over_time("time of a step over ReLCP's", curves)
}

fn rows(study: &Study) -> Panel {
    let of = |run: &Run| curve(run, run.summary.windows.iter().map(|w| (w.time, w.constraints)).collect());
    over_time("rows of a step", study.first_runs().map(of).collect())
}

fn over_time(name: &'static str, curves: Vec<Curve>) -> Panel {
    Panel {
        title: name.into(),
        axes: [Axis { name: "time", logarithmic: false }, Axis { name, logarithmic: true }],
        curves,
        guides: Vec::new(),
    }
}

fn aligned(morphology: &[Morphology], quantity: &'static str) -> Panel {
    let curve = |name: &str, of: fn(&Morphology) -> f64| Curve {
        name: name.into(),
        points: morphology.iter().filter(|of| of.quantity == quantity).map(|m| (m.bodies as f64, of(m))).collect(),
        marked: true,
    };
    Panel {
        title: format!("{quantity}, after a division"),
        axes: [Axis { name: "cells", logarithmic: true }, Axis { name: quantity, logarithmic: false }],
        curves: vec![
            curve(&method_name(Method::Relcp), |m| m.relcp),
            curve(&method_name(Method::Multisphere { count: SHOWN }), |m| m.spheres),
        ],
        guides: Vec::new(),
    }
}
