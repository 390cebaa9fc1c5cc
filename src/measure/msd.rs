//! Mean squared displacement and rotation by lag time, over all pairs of states with this lag (A. Einstein, Ann. Phys.
//! 322, 549 (1905); of rotations S. Kämmerer, W. Kob, R. Schilling, Phys. Rev. E 56, 5450 (1997)), and the persistence
//! of the direction of velocity.
//!
//! The pairs of one body are not independent; different bodies are assumed to be. So standard errors are those of a
//! ratio of sums over bodies (W. G. Cochran, *Sampling Techniques*, 1977, section 6.3).

use super::tracks::{Track, Tracks};
use super::{About, Cell, Column, Counts, Found, LeftOut, Marks, Measure, Profile, Spread, View, cell, count};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

const COLUMNS: [Column; 3] = [
    Column { name: "msd", what: "mean squared displacement since the first state; a length squared" },
    Column { name: "msr", what: "mean squared rotation since the first state, in radians squared" },
    Column { name: "msd_bodies", what: "bodies of the first state that these are the means over" },
];

const PROFILE: [Column; 8] = [
    Column { name: "lag", what: "time between two states" },
    Column { name: "msd", what: "mean squared displacement; a length squared" },
    Column { name: "msd_error", what: "its standard error" },
    Column { name: "msr", what: "mean squared rotation, in radians squared" },
    Column { name: "msr_error", what: "its standard error" },
    Column { name: "direction", what: "mean cosine of the angle between the velocities at both times" },
    Column { name: "bodies", what: "bodies that have such a pair of states" },
    Column { name: "pairs", what: "pairs of states, over all bodies" },
];

/// The largest number of lags: all for up to this many states, else a geometric sequence.
const LAGS: usize = 100;
/// The largest number of rows of the profile: at irregular times, near lags share a row.
const ROWS: usize = 1000;
/// Lags are equal if they differ by less than this part of the whole time, because times are rounded sums of steps.
const SAME: f64 = 1e-9;
/// Bodies whose pairs are summed together: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 64;

/// Mean squared displacement and rotation.
pub(super) struct Msd;

impl Measure for Msd {
    fn about(&self) -> &'static About {
        &About {
            name: "msd",
            line: "mean squared displacement and rotation by lag time",
            columns: &COLUMNS,
            profile: Some(Profile {
                columns: &PROFILE,
                drawn: 1,
                counts: Some(Counts { column: 6, spread: Spread::Column(2) }),
                marks: Marks::Curves,
            }),
            plots: &[&["msd"], &["msr"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        if view.bodies().is_empty() {
            return Err("there is no body".into());
        }
        Ok(Found { values: vec![None; COLUMNS.len()], ..Found::default() })
    }

    fn follows(&self) -> bool {
        true
    }

    fn along(&self, times: &[f64], tracks: &Tracks, found: &mut [Result<Found, LeftOut>]) {
        for (state, found) in found.iter_mut().enumerate() {
            if let Ok(found) = found {
                found.values = since_first(tracks, state);
            }
        }
        let Some(Ok(last)) = found.last_mut() else { return };
        last.rows = profile(times, tracks);
        let drawn = |most| format!("of each state {most} bodies are followed, drawn by their ids");
        last.remark = match (tracks.states(), last.rows.is_empty()) {
            (1, _) => Some("one state alone has no lag".into()),
            (_, true) => Some("no body is in two states".into()),
            _ => tracks.drawn.map(drawn),
        };
    }
}

/// The means over the bodies of the first state that still exist.
fn since_first(tracks: &Tracks, state: usize) -> Vec<Cell> {
    let there = tracks.all.iter().filter(|track| track.first == 0);
    let mut sum = (0.0, 0.0, 0_usize);
    for (from, to) in there.filter_map(|track| Some((track.points.first()?, track.points.get(state)?))) {
        sum.0 += to.position.distance_squared(from.position);
        sum.1 += to.turned.distance_squared(from.turned);
        sum.2 += 1;
    }
    let over = |value: f64| cell(value / sum.2 as f64);
    vec![over(sum.0), over(sum.1), count(sum.2)]
}

/// The lags, as numbers of states, for `states` states.
fn steps(states: usize) -> Vec<usize> {
    let longest = states.saturating_sub(1);
    if longest <= LAGS {
        return (1..=longest).collect();
    }
    let factor = (longest as f64).powf(1.0 / (LAGS - 1) as f64);
    let spaced: BTreeSet<usize> = (0..LAGS).map(|k| factor.powi(k as i32).round() as usize).collect();
    spaced.into_iter().filter(|step| *step <= longest).collect()
}

/// The first lag of each group.
fn groups(times: &[f64], steps: &[usize]) -> Vec<f64> {
    let mut lags: Vec<f64> =
        steps.iter().flat_map(|step| times.iter().zip(&times[*step..]).map(|(from, to)| to - from)).collect();
    lags.sort_unstable_by(f64::total_cmp);
    let Some(&longest) = lags.last() else { return Vec::new() };
    let mut begins: Vec<f64> = Vec::new();
    let mut before = f64::NEG_INFINITY;
    for lag in lags {
        if lag - before > SAME * longest {
            begins.push(lag);
        }
        before = lag;
    }
    if begins.len() <= ROWS {
        return begins;
    }
    (0..ROWS).map(|k| longest * k as f64 / ROWS as f64).collect()
}

/// Sums over the pairs of states of one body.
#[derive(Clone, Copy, Default)]
struct Own {
    pairs: f64,
    lag: f64,
    displacement: f64,
    rotation: f64,
    moving: f64,
    cosine: f64,
}

/// Sums over bodies: of their sums, and of products of these.
#[derive(Clone, Copy, Default)]
struct Sum {
    own: Own,
    bodies: f64,
    pairs_squared: f64,
    displacement: [f64; 2],
    rotation: [f64; 2],
}

impl Sum {
    fn add(&mut self, own: &Own) {
        self.own.pairs += own.pairs;
        self.own.lag += own.lag;
        self.own.displacement += own.displacement;
        self.own.rotation += own.rotation;
        self.own.moving += own.moving;
        self.own.cosine += own.cosine;
        self.bodies += 1.0;
        self.pairs_squared += own.pairs * own.pairs;
        let products = |value: f64| [value * value, value * own.pairs];
        let add = |sums: &mut [f64; 2], value: f64| {
            let [squares, mixed] = products(value);
            *sums = [sums[0] + squares, sums[1] + mixed];
        };
        add(&mut self.displacement, own.displacement);
        add(&mut self.rotation, own.rotation);
    }

    fn join(&mut self, other: &Sum) {
        for (own, more) in [
            (&mut self.own.pairs, other.own.pairs),
            (&mut self.own.lag, other.own.lag),
            (&mut self.own.displacement, other.own.displacement),
            (&mut self.own.rotation, other.own.rotation),
            (&mut self.own.moving, other.own.moving),
            (&mut self.own.cosine, other.own.cosine),
            (&mut self.bodies, other.bodies),
            (&mut self.pairs_squared, other.pairs_squared),
        ] {
            *own += more;
        }
        for k in 0..2 {
            self.displacement[k] += other.displacement[k];
            self.rotation[k] += other.rotation[k];
        }
    }

    /// The standard error of `sum / pairs`; none for a single body.
    fn error(&self, sum: f64, [squares, mixed]: [f64; 2]) -> Cell {
        let mean = sum / self.own.pairs;
        let spread = squares - 2.0 * mean * mixed + mean * mean * self.pairs_squared;
        let variance = spread.max(0.0) * self.bodies / (self.bodies - 1.0);
        if self.bodies > 1.0 { cell(variance.sqrt() / self.own.pairs) } else { None }
    }

    fn row(&self) -> Vec<Cell> {
        let own = &self.own;
        let over = |sum: f64| cell(sum / own.pairs);
        vec![
            over(own.lag),
            over(own.displacement),
            self.error(own.displacement, self.displacement),
            over(own.rotation),
            self.error(own.rotation, self.rotation),
            cell(own.cosine / own.moving),
            cell(self.bodies),
            cell(own.pairs),
        ]
    }
}

fn profile(times: &[f64], tracks: &Tracks) -> Vec<Vec<Cell>> {
    let steps = steps(times.len());
    let begins = groups(times, &steps);
    let parts: Vec<BTreeMap<usize, Sum>> = tracks
        .all
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut sums = BTreeMap::<usize, Sum>::new();
            for track in chunk {
                for (group, own) in of_body(track, times, &steps, &begins) {
                    sums.entry(group).or_default().add(&own);
                }
            }
            sums
        })
        .collect();
    let mut total = BTreeMap::<usize, Sum>::new();
    for (group, sum) in parts.iter().flatten() {
        total.entry(*group).or_default().join(sum);
    }
    total.values().map(Sum::row).collect()
}

/// The sums of one body by group of lags.
fn of_body(track: &Track, times: &[f64], steps: &[usize], begins: &[f64]) -> BTreeMap<usize, Own> {
    let mut sums = BTreeMap::<usize, Own>::new();
    for &step in steps.iter().take_while(|step| **step < track.points.len()) {
        for (k, (from, to)) in track.points.iter().zip(&track.points[step..]).enumerate() {
            let lag = times[track.first + k + step] - times[track.first + k];
            let own = sums.entry(begins.partition_point(|begin| *begin <= lag)).or_default();
            own.pairs += 1.0;
            own.lag += lag;
            own.displacement += to.position.distance_squared(from.position);
            own.rotation += to.turned.distance_squared(from.turned);
            let (a, b) = (from.direction, to.direction);
            if a != glam::DVec3::ZERO && b != glam::DVec3::ZERO {
                own.moving += 1.0;
                own.cosine += a.dot(b);
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lags_are_all_of_few_states_and_spread_over_many() {
        assert_eq!(steps(4), [1, 2, 3]);
        assert!(steps(0).is_empty() && steps(1).is_empty());
        let many = steps(10_000);
        assert!(many.len() > 70 && many.len() <= LAGS && many[..3] == [1, 2, 3] && many.last() == Some(&9999));
        assert!(many.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn equal_lags_are_one_group_and_irregular_ones_share_rows() {
        let even: Vec<f64> = (0..50).map(|k| 0.1 * f64::from(k)).collect();
        assert_eq!(groups(&even, &steps(50)).len(), 49);
        let odd: Vec<f64> = (0..80).map(|k| f64::from(k) + 0.3 * f64::from(k * k % 17)).collect();
        assert!(groups(&odd, &steps(80)).len() <= ROWS);
        let wild: Vec<f64> = (0..101).map(|k| f64::from(k) + 0.5 * f64::from(k).sin()).collect();
        assert_eq!(groups(&wild, &steps(101)).len(), ROWS);
    }
}
