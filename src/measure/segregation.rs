//! The segregation of groups: the part of contacts within a group, over that in a random mixture.
//!
//! In a random mixture, a neighbour belongs to the same group with the probability `sum of n (n - 1) / (N (N - 1))`.
//! Groups whose bodies have more neighbours than others have more contacts within the group for this reason alone. M.
//! E. J. Newman's coefficient of assortativity (Phys. Rev. E 67, 026126 (2003)) corrects for this: `r = (e - a) / (1 -
//! a)` with the part `e` of contacts within groups and `a` the sum of squares of the groups' parts of all ends of
//! contacts; 1 if no two groups touch, 0 if contacts are random, negative if groups alternate.

use super::groups::{alike, number, sizes};
use super::{About, Column, Found, LeftOut, Measure, View, cell, count};
use std::collections::BTreeMap;

const COLUMNS: [Column; 5] = [
    Column { name: "segregation_pairs", what: "pairs that touch" },
    Column { name: "segregation_own", what: "part of these pairs that are of one group" },
    Column { name: "segregation_random", what: "that part in a random mixture of these groups" },
    Column { name: "segregation", what: "the former over the latter: 1 in a random mixture" },
    Column { name: "assortativity", what: "Newman's coefficient: 1 where no two groups touch, 0 at random" },
];

/// Contacts within groups.
pub(super) struct Segregation;

impl Measure for Segregation {
    fn about(&self) -> &'static About {
        &About {
            name: "segregation",
            line: "contacts within groups over those of a random mixture",
            columns: &COLUMNS,
            profile: None,
            plots: &[&["segregation"], &["assortativity"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let group = &view.bodies().group;
        let sizes = sizes(group);
        if sizes.len() < 2 {
            return Err("all bodies are of one group".into());
        }
        let (mut pairs, mut own, mut ends) = (0_usize, 0_usize, BTreeMap::<u32, usize>::new());
        for contact in view.touching() {
            let [a, b] = contact.pair.map(|body| number(group[body]));
            pairs += 1;
            own += usize::from(a == b);
            [a, b].iter().for_each(|of| *ends.entry(*of).or_default() += 1);
        }
        if pairs == 0 {
            return Err("no bodies touch".into());
        }
        let part = own as f64 / pairs as f64;
        let random = alike(&sizes);
        let by_ends: f64 = ends.values().map(|n| (*n as f64 / (2 * pairs) as f64).powi(2)).sum();
        let ratio = random.and_then(|random| cell(part / random));
        // If all contacts are within one group, the coefficient is not defined.
        let assortativity = cell((part - by_ends) / (1.0 - by_ends));
        let values = vec![count(pairs), cell(part), random, ratio, assortativity];
        Ok(Found { values, rows: Vec::new(), remark: None })
    }
}
