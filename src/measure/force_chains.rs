//! Force chains: the contacts that carry more than the mean force, and the components that they connect.
//!
//! The strong part of the force network is that of F. Radjai, M. Jean, J.-J. Moreau, S. Roux, Phys. Rev. Lett. 77, 274
//! (1996); a chain here is one of its connected components, straight or not.

use super::clusters::{SIZE_COLUMNS, components, rows, sizes, summary};
use super::{About, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, count};

const COLUMNS: [Column; 6] = [
    Column { name: "chain_threshold", what: "the mean contact force, over which a contact is in a chain; a force" },
    Column { name: "chain_contacts", what: "contacts over it" },
    Column { name: "chain_share", what: "their part of all contacts that push" },
    Column { name: "chains", what: "components that they connect" },
    Column { name: "chain_mean", what: "mean number of bodies of a chain" },
    Column { name: "chain_largest", what: "bodies of the largest chain" },
];

/// Force chains.
pub(super) struct ForceChains;

impl Measure for ForceChains {
    fn about(&self) -> &'static About {
        &About {
            name: "force_chains",
            line: "force chains: contacts over the mean force and their components",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &SIZE_COLUMNS, drawn: 1, counts: None, marks: Marks::Bars }),
            plots: &[&["chain_mean", "chain_largest"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let pushing: Vec<_> = view.pushing()?.collect();
        if pushing.is_empty() {
            return Err("no pair pushes".into());
        }
        let mean = pushing.iter().map(|contact| contact.gamma).sum::<f64>() / pushing.len() as f64;
        let strong: Vec<[usize; 2]> =
            pushing.iter().filter(|contact| contact.gamma > mean).map(|contact| contact.pair).collect();
        let bodies = view.bodies().len();
        let mut in_chain = vec![false; bodies];
        strong.iter().flatten().for_each(|&body| in_chain[body] = true);
        // The root is a body of its component, so it is in a chain if any of them is.
        let sizes = sizes(&components(bodies, strong.iter().copied()), |root| in_chain[root]);
        let mut values = vec![cell(mean), count(strong.len()), cell(strong.len() as f64 / pushing.len() as f64)];
        values.extend(summary(&sizes));
        Ok(Found { values, rows: rows(&sizes), remark: None })
    }
}
