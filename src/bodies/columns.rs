//! Values that single bodies have beside what their scene gives them: a rate of growth and a division length of their
//! own, and named columns of numbers that a user's rules keep. A division gives both daughters those of their mother.

use super::kept;
use std::collections::BTreeMap;

/// What of a cell's growth is its own, in place of its species'.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OwnGrowth {
    /// Relative growth per time, without pressure; none: that of its species.
    pub rate: Option<f64>,
    /// The tip-to-tip length at which it divides, as soon as its halves are not shorter than thick, whatever the rule
    /// of its species; none: by that rule. Infinite: never.
    pub division_length: Option<f64>,
}

/// The values that single bodies have of their own. In a simulation whose state was never changed there are none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// How many bodies there are; zero where nothing is kept.
    rows: usize,
    /// Empty where no body has any.
    growth: Vec<OwnGrowth>,
    named: BTreeMap<String, Vec<f64>>,
}

impl Columns {
    /// Whether no body has a value of its own.
    pub fn is_empty(&self) -> bool {
        self.growth.is_empty() && self.named.is_empty()
    }

    /// What of body `i`'s growth is its own.
    pub fn growth(&self, i: usize) -> OwnGrowth {
        self.growth.get(i).copied().unwrap_or_default()
    }

    /// Whether a body has growth of its own.
    pub fn has_growth(&self) -> bool {
        !self.growth.is_empty()
    }

    /// The column of this name, a number for each body.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.named.get(name).map(Vec::as_slice)
    }

    /// All named columns, in the order of their names.
    pub fn named(&self) -> impl Iterator<Item = (&str, &[f64])> {
        self.named.iter().map(|(name, values)| (name.as_str(), values.as_slice()))
    }

    /// The growth of body `i` of `bodies`, to be set.
    pub(crate) fn growth_mut(&mut self, i: usize, bodies: usize) -> &mut OwnGrowth {
        self.rows = bodies;
        if self.growth.is_empty() {
            self.growth.resize(bodies, OwnGrowth::default());
        }
        &mut self.growth[i]
    }

    /// The named column of `bodies` numbers, to be set; a new one is zero.
    pub(crate) fn named_mut(&mut self, name: &str, bodies: usize) -> &mut [f64] {
        self.rows = bodies;
        self.named.entry(name.to_owned()).or_insert_with(|| vec![0.0; bodies])
    }

    /// Adds the row of a body that has no values of its own.
    pub(super) fn push(&mut self) {
        self.resize(self.rows + 1);
    }

    /// Adds a row with the values of body `i`.
    #[cfg(feature = "gpu")]
    pub(crate) fn push_like(&mut self, i: usize) {
        self.push();
        self.copy(i, self.rows.saturating_sub(1));
    }

    /// Gives body `to` the values of body `from`.
    pub(crate) fn copy(&mut self, from: usize, to: usize) {
        if !self.growth.is_empty() {
            self.growth[to] = self.growth[from];
        }
        self.named.values_mut().for_each(|values| values[to] = values[from]);
    }

    /// Keeps the first `bodies` rows, or adds rows without values.
    pub(crate) fn resize(&mut self, bodies: usize) {
        if self.is_empty() {
            return;
        }
        self.rows = bodies;
        if !self.growth.is_empty() {
            self.growth.resize(bodies, OwnGrowth::default());
        }
        self.named.values_mut().for_each(|values| values.resize(bodies, 0.0));
    }

    /// Keeps the flagged rows, in order.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        if self.is_empty() {
            return;
        }
        kept(&mut self.growth, keep);
        self.named.values_mut().for_each(|values| kept(values, keep));
        self.rows = keep.iter().filter(|keep| **keep).count();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_bodies_that_come_divide_and_go() {
        let mut columns = Columns::default();
        columns.push();
        columns.retain(&[true]);
        assert!(columns.is_empty() && columns == Columns::default(), "no values take no memory");
        columns.growth_mut(1, 3).rate = Some(0.25);
        columns.named_mut("age", 3).copy_from_slice(&[1.0, 2.0, 3.0]);
        columns.push();
        assert_eq!((columns.growth(3), columns.get("age").unwrap()), (OwnGrowth::default(), &[1.0, 2.0, 3.0, 0.0][..]));
        columns.copy(1, 3);
        columns.retain(&[false, true, false, true]);
        assert_eq!([0, 1].map(|i| columns.growth(i).rate), [Some(0.25); 2]);
        assert_eq!(columns.get("age").unwrap(), [2.0, 2.0]);
        columns.resize(1);
        assert_eq!((columns.get("age").unwrap(), columns.get("none")), (&[2.0][..], None));
    }
}
