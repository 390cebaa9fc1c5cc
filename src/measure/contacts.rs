//! Contacts of the bodies: mean coordination `2 N_c / N`, the number of bodies without contacts, and the distribution.
//!
//! Two bodies touch if their separation is at most the cutoff, which every state determines; they push each other if a
//! multiplier of their rows is above zero, which only a checkpoint has. M. van Hecke, J. Phys. Condens. Matter 22,
//! 033101 (2010) for the coordination number.

use super::{About, Cell, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, count};

const COLUMNS: [Column; 7] = [
    Column { name: "contact_cutoff", what: "separation up to which a pair touches; a length" },
    Column { name: "touching", what: "pairs that touch" },
    Column { name: "touching_per_body", what: "mean number of bodies that a body touches" },
    Column { name: "touching_none", what: "bodies that touch none" },
    Column { name: "pushing", what: "pairs with a contact force above zero" },
    Column { name: "pushing_per_body", what: "mean number of bodies that push a body" },
    Column { name: "pushing_none", what: "bodies that none pushes" },
];

const PROFILE: [Column; 3] = [
    Column { name: "contacts", what: "contacts of a body" },
    Column { name: "touching", what: "bodies with this many touching neighbours" },
    Column { name: "pushing", what: "bodies with this many pushing neighbours" },
];

/// Contacts of the bodies.
pub(super) struct Contacts;

impl Measure for Contacts {
    fn about(&self) -> &'static About {
        &About {
            name: "contacts",
            line: "contacts per body: those that touch, and those that push",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &PROFILE, drawn: 1, counts: None, marks: Marks::Bars }),
            plots: &[&["touching_per_body", "pushing_per_body"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let bodies = view.bodies().len();
        if bodies == 0 {
            return Err("there is no body".into());
        }
        let touching = Coordination::of(bodies, view.touching().map(|contact| contact.pair));
        let (pushing, remark) = match view.pushing() {
            Ok(pushing) => (Some(Coordination::of(bodies, pushing.map(|contact| contact.pair))), None),
            Err(LeftOut(reason)) => (None, Some(format!("pushing: {reason}"))),
        };
        let mut values = vec![cell(view.cutoff())];
        values.extend(touching.values());
        values.extend(pushing.as_ref().map_or([None; 3], Coordination::values));
        let most = touching.histogram.len().max(pushing.as_ref().map_or(0, |pushing| pushing.histogram.len()));
        let row = |n: usize| vec![count(n), touching.with(n), pushing.as_ref().and_then(|pushing| pushing.with(n))];
        Ok(Found { values, rows: (0..most).map(row).collect(), remark })
    }
}

/// The numbers of contacts of the bodies.
struct Coordination {
    bodies: usize,
    pairs: usize,
    /// Bodies by their number of contacts.
    histogram: Vec<usize>,
}

impl Coordination {
    fn of(bodies: usize, pairs: impl Iterator<Item = [usize; 2]>) -> Self {
        let mut contacts = vec![0_usize; bodies];
        let pairs = pairs.inspect(|pair| pair.iter().for_each(|&body| contacts[body] += 1)).count();
        let mut histogram = vec![0; contacts.iter().max().map_or(0, |most| most + 1)];
        contacts.iter().for_each(|&number| histogram[number] += 1);
        Coordination { bodies, pairs, histogram }
    }

    fn values(&self) -> [Cell; 3] {
        [count(self.pairs), cell(2.0 * self.pairs as f64 / self.bodies as f64), self.with(0)]
    }

    fn with(&self, contacts: usize) -> Cell {
        count(self.histogram.get(contacts).copied().unwrap_or(0))
    }
}
