//! Lengths of rods and of other bodies that grow, tip to tip: mean, standard deviation (of the population: divided by
//! N), extremes, histogram.

use super::view::median;
use super::{About, Column, Counts, Found, LeftOut, Marks, Measure, Profile, Spread, View, cell, count};
use std::collections::BTreeMap;

const COLUMNS: [Column; 5] = [
    Column { name: "length_rods", what: "bodies that have a length, tip to tip" },
    Column { name: "length_mean", what: "their mean length" },
    Column { name: "length_sd", what: "standard deviation of their lengths" },
    Column { name: "length_least", what: "the least length" },
    Column { name: "length_most", what: "the largest length" },
];

const PROFILE: [Column; 3] = [
    Column { name: "length", what: "middle of the bin; a length" },
    Column { name: "density", what: "part of the rods in the bin over its width; over all bins it integrates to 1" },
    Column { name: "bodies", what: "rods in the bin" },
];

/// Bins per thickness: a cell that grows from two to four diameters passes sixteen.
const BINS_PER_THICKNESS: f64 = 8.0;

/// Lengths.
pub(super) struct Length;

impl Measure for Length {
    fn about(&self) -> &'static About {
        &About {
            name: "length",
            line: "lengths of rods and their histogram",
            columns: &COLUMNS,
            profile: Some(Profile {
                columns: &PROFILE,
                drawn: 1,
                counts: Some(Counts { column: 2, spread: Spread::OfCount }),
                marks: Marks::Curves,
            }),
            plots: &[&["length_mean", "length_least", "length_most"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let rods = || view.bodies().shape.iter().filter_map(|shape| Some((view.length(shape)?, shape.thickness())));
        let lengths: Vec<f64> = rods().map(|(length, _)| length).collect();
        if lengths.is_empty() {
            return Err("no body has a length, tip to tip".into());
        }
        let number = lengths.len() as f64;
        let mean = lengths.iter().sum::<f64>() / number;
        let variance = lengths.iter().map(|length| (length - mean).powi(2)).sum::<f64>() / number;
        let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
        let most = lengths.iter().copied().fold(0.0, f64::max);
        let width = median(rods().map(|(_, thickness)| thickness)) / BINS_PER_THICKNESS;
        let mut bins = BTreeMap::<u64, usize>::new();
        for length in &lengths {
            *bins.entry((length / width) as u64).or_default() += 1;
        }
        let row = |(bin, rods): (&u64, &usize)| {
            vec![cell((*bin as f64 + 0.5) * width), cell(*rods as f64 / (number * width)), count(*rods)]
        };
        Ok(Found {
            values: vec![count(lengths.len()), cell(mean), cell(variance.sqrt()), cell(least), cell(most)],
            rows: bins.iter().map(row).collect(),
            remark: None,
        })
    }
}
