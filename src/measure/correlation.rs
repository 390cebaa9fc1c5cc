//! Orientational correlation by distance, and its length.
//!
//! `C(r) = <cos 2 (theta_i - theta_j)>` in the plane, `<P_2(n_i . n_j)>` in space, over the pairs whose centres are `r`
//! apart; the length is the distance at which `C` first falls to `1/e`, from `C(0) = 1`, by linear interpolation
//! between the bins' mean distances. D. Frenkel, R. Eppenga, Phys. Rev. A 31, 1776 (1985) for `g_2(r)` in the plane;
//! for colonies R. Los et al., arXiv:2003.10509 (2020).
//!
//! If there are more pairs than [`super::CORRELATION_PAIRS`], only the pairs of some bodies with all others count. A
//! seed selects these bodies: the probability of a pair does not depend on its distance, so the mean is unbiased. The
//! column of pairs shows how reliable a bin is.

use super::bins::Bins;
use super::{About, Cell, Column, Counts, Found, LeftOut, Marks, Measure, Profile, Spread, View, cell, count};
use crate::periodic::Periods;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::E;

const COLUMNS: [Column; 4] = [
    Column { name: "correlation_length", what: "where C(r) first falls to 1/e; a length" },
    Column { name: "correlation_bin", what: "width of the bins of C(r); a length" },
    Column { name: "correlation_pairs", what: "pairs that C(r) is made from" },
    Column {
        name: "correlation_references",
        what: "bodies whose pairs with all others are counted: all, or those drawn",
    },
];

const PROFILE: [Column; 3] = [
    Column { name: "distance", what: "mean distance of the bin's pairs; a length" },
    Column { name: "correlation", what: "C(r)" },
    Column { name: "pairs", what: "pairs in the bin" },
];

/// The standard deviation of a pair's term for independent axes: that of `cos 2 theta` and of `cos theta` in the plane,
/// an upper bound of those of `P_2` and `cos theta` in space.
pub(super) const DEVIATION: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Bodies whose pairs are summed together: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 32;

/// Orientational correlation.
pub(super) struct Correlation;

impl Measure for Correlation {
    fn about(&self) -> &'static About {
        &About {
            name: "correlation",
            line: "orientational correlation by distance, and its length",
            columns: &COLUMNS,
            profile: Some(Profile {
                columns: &PROFILE,
                drawn: 1,
                counts: Some(Counts { column: 2, spread: Spread::OfMean(DEVIATION) }),
                marks: Marks::Curves,
            }),
            plots: &[&["correlation_length"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let bodies: Vec<(DVec3, DVec3)> =
            view.bodies().position.iter().zip(&view.axes).filter_map(|(x, axis)| Some((*x, (*axis)?))).collect();
        if bodies.len() < 2 {
            return Err("fewer than two bodies have an axis".into());
        }
        let planar = view.planar();
        let term = |cosine: f64| if planar { 2.0 * cosine * cosine - 1.0 } else { 1.5 * cosine * cosine - 0.5 };
        let pairs = Pairs::of(view, &bodies, term)?;
        Ok(Found {
            values: vec![pairs.length(), cell(pairs.bin), cell(pairs.number()), count(pairs.references)],
            rows: pairs.rows(),
            remark: pairs.remark("C(r)", view),
        })
    }
}

/// A correlation by distance: the sums of its bins.
pub(super) struct Pairs {
    sums: Vec<Sum>,
    /// Width of the bins.
    pub bin: f64,
    /// Bodies whose pairs with all others are counted.
    pub references: usize,
    bodies: usize,
}

impl Pairs {
    /// Sums over pairs of `bodies`, each with its centre and a direction; `term` maps the cosine between the directions
    /// of a pair to its term.
    pub fn of(view: &View<'_>, bodies: &[(DVec3, DVec3)], term: impl Fn(f64) -> f64 + Sync) -> Result<Pairs, LeftOut> {
        if bodies.len() < 2 {
            return Err("a single body has no pair".into());
        }
        let reach = bodies.iter().map(|(x, _)| x.distance(view.centre)).fold(0.0, f64::max);
        let periods = view.bodies().periods;
        let range = periods.shortest().map_or(2.0 * reach, half);
        let bins = Bins::new(view.bin(), range).ok_or("the bodies have no extent")?;
        let references = references(bodies.len(), view.settings.seed, view.settings.correlation_pairs);
        let all = references.len() == bodies.len();
        let sums = sum(bodies, &references, all, (bins, periods), term);
        Ok(Pairs { sums, bin: bins.width, references: references.len(), bodies: bodies.len() })
    }

    /// The number of pairs.
    pub fn number(&self) -> f64 {
        self.sums.iter().map(|sum| sum.pairs).sum()
    }

    /// One row per bin with pairs.
    pub fn rows(&self) -> Vec<Vec<Cell>> {
        self.sums.iter().filter(|sum| sum.pairs > 0.0).map(Sum::row).collect()
    }

    /// A remark on the correlation, which it calls `name`.
    pub fn remark(&self, name: &str, view: &View<'_>) -> Option<String> {
        let mut remark = Vec::new();
        if self.length().is_none() {
            remark.push(format!("{name} does not fall to 1/e"));
        }
        let (drawn, of) = (self.references, self.bodies);
        if drawn < of {
            let seed = view.settings.seed;
            remark.push(format!("{name} is sampled: the pairs of {drawn} bodies of {of}, selected by seed {seed}"));
        }
        (!remark.is_empty()).then(|| remark.join("; "))
    }

    /// The distance at which the means first cross `1/e`.
    pub fn length(&self) -> Option<f64> {
        let mut before = (0.0, 1.0);
        for sum in self.sums.iter().filter(|sum| sum.pairs > 0.0) {
            let here = sum.mean();
            if here.1 <= 1.0 / E {
                let part = (before.1 - 1.0 / E) / (before.1 - here.1);
                return cell(before.0 + part * (here.0 - before.0));
            }
            before = here;
        }
        None
    }
}

/// All bodies if they have at most `most` pairs; else as many random ones as have about `most` pairs, at least one.
fn references(bodies: usize, seed: u64, most: usize) -> Vec<usize> {
    let mut indices: Vec<usize> = (0..bodies).collect();
    if bodies * (bodies - 1) / 2 <= most {
        return indices;
    }
    // The first entries of a Fisher-Yates shuffle.
    let wanted = (most / (bodies - 1)).max(1);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for place in 0..wanted {
        let from = place + (random.random::<f64>() * (bodies - place) as f64) as usize;
        indices.swap(place, from.min(bodies - 1));
    }
    indices.truncate(wanted);
    indices.sort_unstable();
    indices
}

#[derive(Clone, Copy, Default)]
struct Sum {
    pairs: f64,
    distance: f64,
    correlation: f64,
}

impl Sum {
    fn mean(&self) -> (f64, f64) {
        (self.distance / self.pairs, self.correlation / self.pairs)
    }

    fn row(&self) -> Vec<Cell> {
        let (distance, correlation) = self.mean();
        vec![cell(distance), cell(correlation), cell(self.pairs)]
    }
}

/// The largest distance of pairs in periodic space: beyond it, other images than the nearest are as far away.
fn half(period: f64) -> f64 {
    0.5 * period
}

fn sum(
    bodies: &[(DVec3, DVec3)],
    references: &[usize],
    all: bool,
    (bins, periods): (Bins, Periods),
    term: impl Fn(f64) -> f64 + Sync,
) -> Vec<Sum> {
    let most = periods.shortest().map_or(f64::INFINITY, half);
    let parts: Vec<Vec<Sum>> = references
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut sums = vec![Sum::default(); bins.count];
            for &i in chunk {
                let (position, axis) = bodies[i];
                let from = if all { i + 1 } else { 0 };
                for (j, (other, turned)) in bodies.iter().enumerate().skip(from) {
                    let distance = periods.nearest(*other - position).length();
                    let Some(bin) = bins.of(distance).filter(|_| j != i && distance <= most) else { continue };
                    sums[bin].pairs += 1.0;
                    sums[bin].distance += distance;
                    sums[bin].correlation += term(axis.dot(*turned));
                }
            }
            sums
        })
        .collect();
    let mut total = vec![Sum::default(); bins.count];
    for part in &parts {
        for (total, part) in total.iter_mut().zip(part) {
            total.pairs += part.pairs;
            total.distance += part.distance;
            total.correlation += part.correlation;
        }
    }
    total
}
