//! Friction of the contacts that push: how much of it they use, and which of them slide.
//!
//! A contact uses the part `|t| / mu gamma` of the friction that its normal force `gamma` allows. This is its mobilised
//! friction (for packings: L. E. Silbert, D. Ertas, G. S. Grest, T. C. Halsey, D. Levine, Phys. Rev. E 65, 051302
//! (2002)); at 1 it slides. Contacts with walls count.

use super::{About, Column, Found, LeftOut, Measure, View, cell, count};
use crate::warm::Warm;

const COLUMNS: [Column; 5] = [
    Column { name: "friction_contacts", what: "contacts that push and have friction, with walls too" },
    Column { name: "friction_mobilised", what: "mean part of the friction that they may have and use; 0 to 1" },
    Column { name: "friction_sliding", what: "part of them that slide: they use all of it" },
    Column { name: "friction_force_mean", what: "mean friction force; a force" },
    Column { name: "friction_force_most", what: "the largest friction force" },
];

/// A contact that uses all but this part of its friction slides: a contact that a step leaves at its limit is there to
/// rounding, and a branch of several rows nearly.
const AT_THE_LIMIT: f64 = 1e-6;

/// Friction of contacts.
pub(super) struct Friction;

impl Measure for Friction {
    fn about(&self) -> &'static About {
        &About {
            name: "friction",
            line: "friction of contacts: how much of it they use, and which slide",
            columns: &COLUMNS,
            profile: None,
            plots: &[&["friction_mobilised", "friction_sliding"], &["friction_force_mean", "friction_force_most"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let coefficients = view.frame.friction.as_ref().ok_or("the run's scene is not there, or has no friction")?;
        let used = |warm: &Warm| {
            let coefficient = coefficients.of_pair(warm.pair, &view.bodies().group);
            let force = warm.tangent.length();
            (coefficient > 0.0).then(|| (force, force / (coefficient * warm.gamma)))
        };
        let all: Vec<_> = view.forces()?.iter().filter(|warm| warm.gamma > 0.0).filter_map(used).collect();
        let mean = |sum: f64| if all.is_empty() { None } else { cell(sum / all.len() as f64) };
        let sliding = all.iter().filter(|(_, part)| *part >= 1.0 - AT_THE_LIMIT).count();
        let most = all.iter().fold(0.0, |most: f64, (force, _)| most.max(*force));
        let values = vec![
            count(all.len()),
            mean(all.iter().map(|(_, part)| part).sum()),
            mean(sliding as f64),
            mean(all.iter().map(|(force, _)| force).sum()),
            (!all.is_empty()).then_some(most),
        ];
        Ok(Found { values, ..Found::default() })
    }
}
