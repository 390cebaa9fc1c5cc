//! Removed bodies: their number so far, by rule, and their rate since the last state.

use super::{About, Cell, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, count};

const COLUMNS: [Column; 3] = [
    Column { name: "removed", what: "bodies removed since the start" },
    Column {
        name: "removed_share",
        what: "the same over removed and present bodies: 1 less the survival if none is born",
    },
    Column { name: "removal_rate", what: "bodies removed since the last state, per time" },
];

const PROFILE: [Column; 2] = [
    Column { name: "rule", what: "index of the rule in the scene's `removal`, from 0" },
    Column { name: "removed", what: "bodies that it removed since the start" },
];

/// The columns of the number and of the rate.
const REMOVED: usize = 0;
const RATE: usize = 2;

/// Removed bodies.
pub(super) struct Removed;

impl Measure for Removed {
    fn about(&self) -> &'static About {
        &About {
            name: "removal",
            line: "bodies removed, and the rate at which they leave",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &PROFILE, drawn: 1, counts: None, marks: Marks::Kinds }),
            plots: &[&["removed"], &["removal_rate"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let removed = &view.state.removed;
        if removed.is_empty() && !view.frame.removes {
            return Err("the scene removes no bodies".into());
        }
        let all: u64 = removed.iter().sum();
        let row = |(rule, n): (usize, &u64)| vec![count(rule), cell(*n as f64)];
        Ok(Found {
            values: vec![cell(all as f64), cell(all as f64 / (all as f64 + view.bodies().len() as f64)), None],
            rows: removed.iter().enumerate().map(row).collect(),
            remark: None,
        })
    }

    fn over_time(&self, times: &[f64], found: &mut [Result<Found, LeftOut>]) {
        let removed = |found: &Result<Found, LeftOut>| found.as_ref().ok().and_then(|found| found.values[REMOVED]);
        let removed: Vec<Cell> = found.iter().map(removed).collect();
        for (i, found) in found.iter_mut().enumerate().skip(1) {
            if let (Ok(found), Some(before), Some(now)) = (found, removed[i - 1], removed[i]) {
                found.values[RATE] = cell((now - before) / (times[i] - times[i - 1]));
            }
        }
    }
}
