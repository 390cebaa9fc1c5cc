//! Lengths of rods that differ.
//!
//! They are not drawn, but are the quantiles `(k + 1/2) / n` of a distribution, so that `n` rods have it as nearly as
//! that many can, dealt out in an order in which neighbours of the list differ.

use crate::shape::Shape;
#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};

/// The distribution of the lengths of rods: they are its quantiles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Lengths {
    /// All lengths between two are equally likely.
    Uniform {
        /// The shortest.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        from: f64,
        /// The longest.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        to: f64,
    },
    /// Cells in steady growth at a rate, which divide at twice the length that they are born with: a length `l` has the
    /// density `2 birth / l^2`.
    Dividing {
        /// The length at birth, the shortest.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        birth: f64,
    },
}

impl Lengths {
    /// The distribution's name, which is its key.
    pub(in super::super) fn name(&self) -> &'static str {
        match self {
            Lengths::Uniform { .. } => "uniform",
            Lengths::Dividing { .. } => "dividing",
        }
    }

    /// Its settings, which do not fall.
    pub(in super::super) fn bounds(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Lengths::Uniform { from, to } => vec![("from", from), ("to", to)],
            Lengths::Dividing { birth } => vec![("birth", birth)],
        }
    }

    /// The length that a part `quantile` of all rods is not longer than.
    pub(in super::super) fn at(&self, quantile: f64) -> f64 {
        match *self {
            Lengths::Uniform { from, to } => from + quantile * (to - from),
            Lengths::Dividing { birth } => birth / (1.0 - 0.5 * quantile),
        }
    }
}

/// The golden section: steps of this part of a circle spread out best.
const SECTION: f64 = 0.618_033_988_749_895;

/// A step near the golden section of `count` that visits all numbers below it.
fn stride(count: u64) -> u64 {
    let common = |mut a: u64, mut b: u64| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let first = ((count as f64 * SECTION) as u64).max(1);
    (first..).find(|step| common(*step, count) == 1).unwrap_or(1)
}

/// How many bodies there are of each shape: with lengths, each has its own.
pub(in super::super) fn spread(count: u64, shape: Shape, lengths: Option<&Lengths>) -> Vec<(u64, Shape)> {
    let Some(lengths) = lengths else { return vec![(count, shape)] };
    let step = stride(count);
    let quantile = |k: u64| (((k * step) % count) as f64 + 0.5) / count as f64;
    (0..count).map(|k| (1, shape.grown(lengths.at(quantile(k))).unwrap_or(shape))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All quantiles of each number of rods, each once: mean and spread are those of the distribution.
    #[test]
    fn lengths_have_their_distribution() {
        let rod = Shape::Spherocylinder { diameter: 0.5, length: 1.0 };
        for count in [1, 2, 3, 10, 24, 97, 1000] {
            let of = |lengths: Lengths| -> Vec<f64> {
                spread(count, rod, Some(&lengths)).iter().map(|(_, shape)| shape.major_axis()).collect()
            };
            let mut uniform = of(Lengths::Uniform { from: 1.0, to: 3.0 });
            let steps = count as f64;
            if count > 10 {
                // Neighbours of the list differ by more than a fifth of the range.
                assert!(uniform.windows(2).all(|pair| (pair[1] - pair[0]).abs() > 0.4), "{count}");
            }
            uniform.sort_by(f64::total_cmp);
            for (k, length) in uniform.iter().enumerate() {
                assert!((length - 1.0 - 2.0 * (k as f64 + 0.5) / steps).abs() < 1e-12, "{count}");
            }
            // The mean of 2 b / l^2 from b to 2 b is 2 b ln 2.
            let dividing = of(Lengths::Dividing { birth: 1.0 });
            let mean = dividing.iter().sum::<f64>() / steps;
            assert!((mean - 2.0 * std::f64::consts::LN_2).abs() < 0.1 / (steps * steps), "{count}: {mean}");
            assert!(dividing.iter().all(|length| (1.0..2.0).contains(length)));
        }
        assert_eq!(spread(7, rod, None), [(7, rod)]);
    }
}
