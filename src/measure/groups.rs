//! Number and lengths of the bodies by group: species and strains.
//!
//! Simpson's index measures how even a mixture is: the probability that two bodies drawn at random are of different
//! groups, `1 - sum of n (n - 1) / (N (N - 1))` (E. H. Simpson, Nature 163, 688 (1949)). Bodies without a group are a
//! group of their own.

use super::{About, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, count};
use crate::bodies::NO_GROUP;
use std::collections::BTreeMap;

const COLUMNS: [Column; 5 + NAMED] = [
    Column { name: "groups", what: "groups that have a body; bodies without a group are one" },
    Column { name: "group_largest", what: "bodies of the largest group" },
    Column { name: "group_smallest", what: "bodies of the smallest group" },
    Column { name: "group_largest_share", what: "part of all bodies that the largest group is" },
    Column { name: "group_diversity", what: "probability that two bodies are of different groups (Simpson)" },
    Column { name: "group_1", what: "bodies of the scene's first group; none without it" },
    Column { name: "group_2", what: "likewise, of the second" },
    Column { name: "group_3", what: "likewise, of the third" },
    Column { name: "group_4", what: "likewise, of the fourth" },
];

/// The groups with a column of their own: two strains and their controls. The profile has all.
const NAMED: usize = 4;

const PROFILE: [Column; 5] = [
    Column { name: "group", what: "the group's number in the scene's order, from 1; 0 is of bodies without one" },
    Column { name: "bodies", what: "its bodies" },
    Column { name: "share", what: "part of all bodies" },
    Column { name: "length", what: "sum of the lengths of its rods, tip to tip" },
    Column { name: "length_mean", what: "their mean length" },
];

/// Bodies by group.
pub(super) struct Groups;

/// A group's number in tables and pictures: from 1, and 0 for none.
pub(crate) fn number(group: u32) -> u32 {
    if group == NO_GROUP { 0 } else { group.saturating_add(1) }
}

/// The number of bodies in each group.
pub(super) fn sizes(groups: &[u32]) -> BTreeMap<u32, usize> {
    let mut sizes = BTreeMap::new();
    groups.iter().for_each(|group| *sizes.entry(number(*group)).or_default() += 1);
    sizes
}

/// The probability that two bodies drawn at random are of one group; none with fewer than two bodies.
pub(super) fn alike(sizes: &BTreeMap<u32, usize>) -> Option<f64> {
    let pairs = |n: usize| n as f64 * (n as f64 - 1.0);
    let all: usize = sizes.values().sum();
    (all > 1).then(|| sizes.values().map(|n| pairs(*n)).sum::<f64>() / pairs(all))
}

impl Measure for Groups {
    fn about(&self) -> &'static About {
        &About {
            name: "groups",
            line: "numbers and lengths of bodies by group",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &PROFILE, drawn: 1, counts: None, marks: Marks::Kinds }),
            plots: &[
                &["group_1", "group_2", "group_3", "group_4"],
                &["group_largest", "group_smallest"],
                &["group_diversity"],
            ],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let bodies = view.bodies();
        let sizes = sizes(&bodies.group);
        let (Some(largest), Some(smallest)) = (sizes.values().max(), sizes.values().min()) else {
            return Err("there is no body".into());
        };
        let all = bodies.len() as f64;
        let mut lengths = BTreeMap::<u32, (f64, usize)>::new();
        for (shape, group) in bodies.shape.iter().zip(&bodies.group) {
            let Some(length) = view.length(shape) else { continue };
            let own = lengths.entry(number(*group)).or_default();
            *own = (own.0 + length, own.1 + 1);
        }
        let known = sizes.keys().max().map_or(0, |last| *last as usize).max(view.frame.group_names.len());
        let own = (1..=NAMED).map(|group| {
            let bodies = sizes.get(&(group as u32)).copied().unwrap_or(0);
            (group <= known).then(|| count(bodies)).flatten()
        });
        let row = |(group, n): (&u32, &usize)| {
            let length = lengths.get(group);
            let mean = length.and_then(|(sum, rods)| cell(sum / *rods as f64));
            let sum = length.and_then(|(sum, _)| cell(*sum));
            vec![cell(f64::from(*group)), count(*n), cell(*n as f64 / all), sum, mean]
        };
        Ok(Found {
            values: [
                count(sizes.len()),
                count(*largest),
                count(*smallest),
                cell(*largest as f64 / all),
                alike(&sizes).map(|alike| 1.0 - alike),
            ]
            .into_iter()
            .chain(own)
            .collect(),
            rows: sizes.iter().map(row).collect(),
            remark: None,
        })
    }
}
