//! The colour quantities: a number for each body and state, in 65,535 steps from zero to the state's largest.

use super::columns::Block;
use super::header::StateHeader;
use crate::bodies::NO_GROUP;
use crate::measure::{LeftOut, View};
use crate::record::Snapshot;
use crate::render::{Quantity, Scale};
use std::collections::BTreeMap;

/// Those that a page is given as numbers; the others follow from what else it has.
const GIVEN: [Quantity; 5] =
    [Quantity::Speed, Quantity::Contacts, Quantity::Overlap, Quantity::Force, Quantity::Pressure];

/// The names of what a page is given as numbers.
pub(super) fn given() -> Vec<&'static str> {
    GIVEN.iter().map(|quantity| quantity.name()).collect()
}

/// The values of a state, by quantity, or why it has none.
pub(super) struct Measured(Vec<(Quantity, Result<Vec<f64>, LeftOut>)>);

impl Measured {
    /// All that is on a scale.
    pub fn of(view: &View<'_>) -> Measured {
        let on_scale = Quantity::ALL.iter().filter(|quantity| quantity.ends().is_some());
        Measured(on_scale.map(|quantity| (*quantity, quantity.of_view(view))).collect())
    }

    /// Adds those that a page is given.
    pub fn pack(&self, block: &mut Block, about: &mut StateHeader) {
        for (quantity, values) in &self.0 {
            let values = match values {
                Ok(values) if GIVEN.contains(quantity) => values,
                Ok(_) => continue,
                Err(LeftOut(why)) => {
                    about.missing.insert(quantity.name(), why.clone());
                    continue;
                }
            };
            let most = values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
            // Whole numbers stay whole.
            let range = if *quantity == Quantity::Contacts { [0.0, f64::from(u16::MAX)] } else { [0.0, most] };
            block.add_between(quantity.name(), values.iter().copied(), range);
            about.ranges.insert(quantity.name(), range);
        }
    }
}

/// The scales of the run.
#[derive(Default)]
pub(super) struct Scales {
    found: BTreeMap<&'static str, Scale>,
    births: bool,
    groups: bool,
}

impl Scales {
    /// Takes a state into account, and tells it its own scales.
    pub fn add(&mut self, state: &Snapshot, measured: &Measured, about: &mut StateHeader) {
        self.births |= state.bodies.lineage.iter().any(|line| line.parent.is_some() || line.generation > 0);
        self.groups |= state.bodies.group.iter().any(|group| *group != NO_GROUP);
        for (quantity, values) in &measured.0 {
            let (Ok(values), Some(ends)) = (values, quantity.ends()) else { continue };
            let Some(scale) = Scale::of(values, ends) else { continue };
            about.scales.insert(quantity.name(), numbers(scale));
            self.found.entry(quantity.name()).and_modify(|all| *all = all.with(scale)).or_insert(scale);
        }
    }

    /// Low end, high end and largest value of a quantity in the run.
    pub fn of(&self, quantity: Quantity) -> Option<[f64; 3]> {
        self.found.get(quantity.name()).copied().map(numbers)
    }

    /// Why a quantity tells nothing of any state; `last` is the last one.
    pub fn missing(&self, quantity: Quantity, last: Option<&StateHeader>) -> Option<String> {
        if quantity.is_of_births() && !self.births {
            return Some("no body was born in these states".into());
        }
        if quantity == Quantity::Group && !self.groups {
            return Some("no body has a group".into());
        }
        if quantity.ends().is_none() || self.found.contains_key(quantity.name()) {
            return None;
        }
        let why = last.and_then(|state| state.missing.get(quantity.name()).cloned());
        Some(why.unwrap_or_else(|| "there is no body".into()))
    }
}

fn numbers(scale: Scale) -> [f64; 3] {
    [scale.low, scale.high, scale.largest]
}
