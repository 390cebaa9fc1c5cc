//! Nematic order, of all bodies and of neighbourhoods.
//!
//! With the axes `n`: in the plane `S = |<exp(2 i theta)>|`, the positive eigenvalue of `<2 n n - I>`, and the
//! director's angle is half that sum's argument; in space the largest eigenvalue of `<(3 n n - I) / 2>`. P. G. de
//! Gennes, J. Prost, "The Physics of Liquid Crystals", 1993, section 2.1; the estimate's excess of order `1 / sqrt(N)`:
//! R. Eppenga, D. Frenkel, Mol. Phys. 52, 1303 (1984).
//!
//! Local order is the mean over the bodies of the `S` of a body and its neighbours within a distance. Two bodies alone
//! have `S` > 0 at any orientation, so the mean number of neighbours is given too.

use super::{About, Column, Found, LeftOut, Measure, View, cell, count};
use crate::measure::view::median;
use glam::{DMat3, DVec3};
use nalgebra::Matrix3;
use rayon::prelude::*;

const COLUMNS: [Column; 6] = [
    Column { name: "nematic_axes", what: "bodies with an axis" },
    Column { name: "nematic_order", what: "order of all axes: 0 isotropic, 1 aligned" },
    Column { name: "nematic_director_degrees", what: "angle of the director from x, 0 to 180; in the plane" },
    Column { name: "nematic_local", what: "mean over the bodies of the order of their neighbourhoods" },
    Column { name: "nematic_local_radius", what: "radius of a neighbourhood, between centres; a length" },
    Column { name: "nematic_local_neighbours", what: "mean number of others in a neighbourhood" },
];

/// The largest number of pairs for local order: a gigabyte.
const MOST_PAIRS: f64 = (1_u32 << 27) as f64;

/// The number of bodies from which the number of pairs is estimated before the search.
const ASKED: usize = 64;

/// Nematic order.
pub(super) struct Nematic;

impl Measure for Nematic {
    fn about(&self) -> &'static About {
        &About {
            name: "nematic",
            line: "nematic order, of all bodies and of neighbourhoods",
            columns: &COLUMNS,
            profile: None,
            plots: &[&["nematic_order", "nematic_local"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let (among, axes): (Vec<usize>, Vec<DVec3>) =
            view.axes.iter().enumerate().filter_map(|(i, axis)| Some((i, (*axis)?))).unzip();
        if axes.is_empty() {
            return Err("no body has an axis".into());
        }
        let mut all = Order::default();
        axes.iter().for_each(|axis| all.add(*axis));
        let radius = view
            .settings
            .neighbourhood
            .unwrap_or_else(|| median(view.bodies().shape.iter().map(|shape| shape.major_axis())));
        // Farther away, images other than the nearest would count too.
        let radius = view.bodies().periods.shortest().map_or(radius, |period| radius.min(0.5 * period));
        let (local, neighbours) = match crowd(view, &among, radius) {
            pairs if pairs > MOST_PAIRS => (None, f64::NAN),
            _ => local(view, &among, &axes, radius),
        };
        let director = view.planar().then(|| all.director_degrees()).flatten();
        Ok(Found {
            values: vec![
                count(axes.len()),
                cell(all.value(view.planar())),
                director,
                local,
                cell(radius),
                cell(neighbours),
            ],
            remark: local.is_none().then(|| no_local(neighbours)),
            ..Found::default()
        })
    }
}

fn no_local(neighbours: f64) -> String {
    if neighbours.is_nan() {
        return "the neighbourhoods hold too many pairs for a local order; choose smaller ones".into();
    }
    "no body has a neighbour with an axis, so there is no local order".into()
}

/// An estimate of the number of pairs of the neighbour search, from some of the bodies, evenly spaced in their order.
fn crowd(view: &View<'_>, among: &[usize], radius: f64) -> f64 {
    let position = |i: &usize| view.bodies().position[*i];
    let periods = view.bodies().periods;
    let asked = || among.iter().step_by(among.len().div_ceil(ASKED));
    let near = |i: &usize| {
        among.iter().filter(|j| periods.nearest(position(i) - position(j)).abs().max_element() <= radius).count() - 1
    };
    let found: usize = asked().map(near).sum();
    0.5 * found as f64 * among.len() as f64 / asked().count() as f64
}

/// The mean order of the neighbourhoods with at least one neighbour, and the mean number of neighbours.
fn local(view: &View<'_>, among: &[usize], axes: &[DVec3], radius: f64) -> (Option<f64>, f64) {
    let mut orders = vec![Order::default(); axes.len()];
    for (order, axis) in orders.iter_mut().zip(axes) {
        order.add(*axis);
    }
    let pairs = view.neighbours(among, radius);
    for pair in &pairs {
        let [a, b] = pair.map(|i| i as usize);
        orders[a].add(axes[b]);
        orders[b].add(axes[a]);
    }
    let planar = view.planar();
    let found: Vec<f64> =
        orders.par_iter().filter(|order| order.bodies > 1.0).map(|order| order.value(planar)).collect();
    let mean = (!found.is_empty()).then(|| found.iter().sum::<f64>() / found.len() as f64);
    (mean, 2.0 * pairs.len() as f64 / axes.len() as f64)
}

/// The sum of the dyads of axes.
#[derive(Clone, Copy, Default)]
struct Order {
    bodies: f64,
    /// xx, xy, yy, xz, yz; zz follows from the trace.
    dyad: [f64; 5],
}

impl Order {
    fn add(&mut self, n: DVec3) {
        self.bodies += 1.0;
        for (sum, term) in self.dyad.iter_mut().zip([n.x * n.x, n.x * n.y, n.y * n.y, n.x * n.z, n.y * n.z]) {
            *sum += term;
        }
    }

    /// `<2 n n - I>` in the plane: its xx and xy.
    fn planar(&self) -> (f64, f64) {
        let [xx, xy, yy, ..] = self.dyad.map(|sum| sum / self.bodies);
        (xx - yy, 2.0 * xy)
    }

    fn value(&self, planar: bool) -> f64 {
        if planar {
            let (xx, xy) = self.planar();
            return xx.hypot(xy);
        }
        let [xx, xy, yy, xz, yz] = self.dyad.map(|sum| sum / self.bodies);
        let zz = 1.0 - xx - yy;
        let dyad = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]).to_cols_array();
        1.5 * Matrix3::from_column_slice(&dyad).symmetric_eigenvalues().max() - 0.5
    }

    /// The angle of the director; none for an isotropic sum.
    fn director_degrees(&self) -> Option<f64> {
        let (xx, xy) = self.planar();
        let degrees = 0.5 * xy.atan2(xx).to_degrees();
        (xx != 0.0 || xy != 0.0).then_some(if degrees < 0.0 { degrees + 180.0 } else { degrees })
    }
}
