//! Time of a step and of an iteration by the number of bodies, and the growth of a colony.

use super::page::{growths, speed_rows};
use super::{Results, SpeedRow};
use crate::StudyError;
use crate::plot::{Axis, Curve, Panel, draw};
use relcp::figure::Figure;

pub(super) fn plots(results: &Results) -> Result<Vec<(&'static str, Figure)>, StudyError> {
    let panel = |title: &str, [x, y]: [&'static str; 2], curves: Vec<Curve>| Panel {
        title: title.into(),
        axes: [x, y].map(|name| Axis { name, logarithmic: true }),
        curves,
        guides: Vec::new(),
    };
    let mut plots = Vec::new();
    let rows = speed_rows(results);
    if !rows.is_empty() {
        let step = panel("a step", ["bodies", "milliseconds"], curves(&rows, |row| row.step_ms));
        let iteration = panel("an iteration", ["bodies", "microseconds"], curves(&rows, |row| row.iteration_us));
        plots.push(("speed", draw("time by the number of bodies", &[vec![step, iteration]])?));
    }
    let growths = growths(results);
    if !growths.is_empty() {
        let curve = |growth: &&super::Growth| Curve {
            name: growth.computed_by.clone(),
            points: growth.doublings.iter().map(|d| (d.wall_seconds, d.cells as f64)).collect(),
            marked: true,
        };
        let panel = panel("", ["seconds", "cells"], growths.iter().map(curve).collect());
        plots.push(("growth", draw("a colony from one cell", &[vec![panel]])?));
    }
    Ok(plots)
}

fn curves(rows: &[&SpeedRow], value: fn(&SpeedRow) -> f64) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in rows {
        let name = format!("{} {}", row.kind.name(), row.precision);
        if curves.last().is_none_or(|curve| curve.name != name) {
            curves.push(Curve { name, points: Vec::new(), marked: true });
        }
        if let Some(curve) = curves.last_mut() {
            curve.points.push((row.bodies as f64, value(row)));
        }
    }
    curves
}
