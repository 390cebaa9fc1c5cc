//! Correlation of the directions of velocity by distance: the range of collective motion.
//!
//! `C_v(r) = <u_i . u_j>` with `u = v / |v|`, over the pairs of moving bodies whose centres are `r` apart (H. P. Zhang,
//! A. Be'er, E.-L. Florin, H. L. Swinney, PNAS 107, 13626 (2010) for colonies); its length is the distance at which it
//! first falls to `1/e`, as in `correlation`. The polar order is `|<u>|` (T. Vicsek, A. Czirók, E. Ben-Jacob, I. Cohen,
//! O. Shochet, Phys. Rev. Lett. 75, 1226 (1995)).

use super::correlation::{self, Pairs};
use super::{About, Column, Counts, Found, LeftOut, Marks, Measure, Profile, Spread, View, cell, count};
use glam::DVec3;

const COLUMNS: [Column; 6] = [
    Column { name: "velocity_correlation_length", what: "where C_v(r) first falls to 1/e; a length" },
    Column { name: "velocity_order", what: "polar order of the velocities: 0 in all directions, 1 in one" },
    Column { name: "speed_mean", what: "mean speed of the bodies that move; a length over time" },
    Column { name: "velocity_bodies", what: "bodies that move" },
    Column { name: "velocity_correlation_bin", what: "width of the bins of C_v(r); a length" },
    Column { name: "velocity_correlation_pairs", what: "pairs that C_v(r) is made from" },
];

const PROFILE: [Column; 3] = [
    Column { name: "distance", what: "mean distance of the bin's pairs; a length" },
    Column { name: "velocity_correlation", what: "C_v(r)" },
    Column { name: "pairs", what: "pairs in the bin" },
];

/// Correlation of velocities.
pub(super) struct VelocityCorrelation;

impl Measure for VelocityCorrelation {
    fn about(&self) -> &'static About {
        &About {
            name: "velocity_correlation",
            line: "correlation of the directions of velocity by distance, and its length",
            columns: &COLUMNS,
            profile: Some(Profile {
                columns: &PROFILE,
                drawn: 1,
                counts: Some(Counts { column: 2, spread: Spread::OfMean(correlation::DEVIATION) }),
                marks: Marks::Curves,
            }),
            plots: &[&["velocity_correlation_length"], &["velocity_order"], &["speed_mean"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let bodies = view.bodies();
        let moving: Vec<(DVec3, DVec3)> = (bodies.position.iter().zip(&bodies.velocity))
            .filter_map(|(x, v)| Some((*x, v.try_normalize()?)))
            .collect();
        if moving.is_empty() {
            return Err("no body moves; under the overdamped law velocities are those of the last step".into());
        }
        let number = moving.len() as f64;
        let order = moving.iter().map(|(_, u)| *u).sum::<DVec3>().length() / number;
        let speed = bodies.velocity.iter().map(|v| v.length()).sum::<f64>() / number;
        let values = |length, bin, pairs| vec![length, cell(order), cell(speed), count(moving.len()), bin, pairs];
        match Pairs::of(view, &moving, |cosine| cosine) {
            Err(LeftOut(reason)) => {
                Ok(Found { values: values(None, None, None), rows: Vec::new(), remark: Some(reason) })
            }
            Ok(pairs) => Ok(Found {
                values: values(pairs.length(), cell(pairs.bin), cell(pairs.number())),
                rows: pairs.rows(),
                remark: pairs.remark("C_v(r)", view),
            }),
        }
    }
}
