//! Packing fraction of the whole and of its core, of a periodic cell, or of what walls leave.
//!
//! Of the whole: the bodies' area over that of their convex hull, in the plane. Of the core: the filled part of the
//! disc (in space the ball) about the mean of the centres with the radius of gyration, so that neither the outline nor
//! bodies beyond it count; a uniform disc has half of its area in the core. Fractions of sections through windows
//! inside a packing: S. Torquato, "Random Heterogeneous Materials", 2002, section 2.6; the hull as a colony's outline
//! is a choice of this program.

use super::{About, Cell, Column, Found, LeftOut, Measure, View, cell, hull, interior, radius};
use crate::walls::{Walls, standing};
use glam::DVec3;
use rayon::prelude::*;

const COLUMNS: [Column; 6] = [
    Column { name: "body_volume", what: "volume of all bodies; in the plane the area of their sections" },
    Column { name: "hull_area", what: "area of the convex hull of all bodies; in the plane" },
    Column { name: "packing_hull", what: "area of the bodies over that of their convex hull; in the plane" },
    Column {
        name: "packing_core",
        what: "part of the disc (in space the ball) of the radius of gyration that bodies fill",
    },
    Column {
        name: "packing_cell",
        what: "volume of all bodies over that of the periodic cell; in the plane areas; where all axes are periodic",
    },
    Column {
        name: "packing_walls",
        what: "volume of all bodies over that inside of the walls, in one periodic cell; in the plane areas",
    },
];

/// Bodies whose points are summed together: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 1024;

/// Packing fraction.
pub(super) struct Packing;

impl Measure for Packing {
    fn about(&self) -> &'static About {
        &About {
            name: "packing",
            line: "packing fraction, of the convex hull and of the core",
            columns: &COLUMNS,
            profile: None,
            plots: &[&["packing_hull", "packing_core"], &["packing_walls"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        if view.bodies().is_empty() {
            return Err("there is no body".into());
        }
        let volume: f64 = view.volumes.iter().sum();
        if view.in_open_space().is_err() {
            return Ok(in_cell(view, volume));
        }
        let hull = view.planar().then(|| hull::area(view));
        let core = core(view);
        let mut remark = Vec::new();
        if hull.is_none() {
            remark.push("the convex hull is measured in the plane only");
        }
        if core.is_none() {
            remark.push("the radius of gyration is zero, so there is no core");
        }
        Ok(Found {
            values: vec![
                cell(volume),
                hull.and_then(cell),
                hull.and_then(|hull| cell(volume / hull)),
                core,
                None,
                in_walls(view, volume),
            ],
            remark: (!remark.is_empty()).then(|| remark.join("; ")),
            ..Found::default()
        })
    }
}

/// The packing fraction in periodic space, which has neither an outline nor a core.
fn in_cell(view: &View<'_>, volume: f64) -> Found {
    let periods = view.bodies().periods;
    let packing = periods.volume(view.planar()).and_then(|whole| cell(volume / whole));
    let remark = match packing {
        Some(_) => "a periodic scene has no outline and no core",
        None => "a periodic scene has no outline and no core, and one with an open axis has no cell",
    };
    Found {
        values: vec![cell(volume), None, None, None, packing, in_walls(view, volume)],
        remark: Some(remark.into()),
        ..Found::default()
    }
}

/// The packing fraction inside of walls that leave no way out, where loads and motions have them.
fn in_walls(view: &View<'_>, volume: f64) -> Cell {
    let walls = standing(&view.frame.walls, &view.bodies().walls);
    let walls = Walls::new(&walls, view.planar()).at(view.state.time);
    let plane = view.planar().then_some(view.centre.z);
    cell(volume / walls.space(&view.bodies().periods, plane)?)
}

fn core(view: &View<'_>) -> Option<f64> {
    let gyration = radius::gyration(view);
    let filled = spread(view, 1, |distance| (distance <= gyration).then_some(0));
    if gyration > 0.0 { cell(filled[0] / view.ball(gyration)) } else { None }
}

/// The volume of all bodies, distributed to `count` bins: `place` gives the bin of a distance from the centre, and the
/// distances of a bin are an interval.
pub(super) fn spread(view: &View<'_>, count: usize, place: impl Fn(f64) -> Option<usize> + Sync) -> Vec<f64> {
    let bodies = view.bodies();
    let starts: Vec<usize> = (0..bodies.len()).step_by(CHUNK).collect();
    let part = |&start: &usize| {
        let mut sums = vec![0.0; count];
        let mut points: Vec<DVec3> = Vec::new();
        for i in start..bodies.len().min(start + CHUNK) {
            let (distance, reach) = (view.distance(i), bodies.shape[i].bounding_radius());
            let nearest = place((distance - reach).max(0.0));
            if nearest == place(distance + reach) {
                nearest.into_iter().for_each(|place| sums[place] += view.volumes[i]);
                continue;
            }
            interior::points(&bodies.shape[i], bodies.orientation[i], view.axes[i], view.planar(), &mut points);
            let share = view.volumes[i] / points.len() as f64;
            let from_centre = bodies.position[i] - view.centre;
            for place in points.iter().filter_map(|point| place((from_centre + *point).length())) {
                sums[place] += share;
            }
        }
        sums
    };
    let parts: Vec<Vec<f64>> = starts.par_iter().map(part).collect();
    let mut total = vec![0.0; count];
    for part in &parts {
        total.iter_mut().zip(part).for_each(|(total, part)| *total += part);
    }
    total
}
