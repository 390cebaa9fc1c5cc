//! Cells that have no room to grow.

/// Cells that wait in a piece of a step: they neither grow nor divide.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Waiting {
    /// None.
    #[default]
    None,
    /// Those with these ids, sorted.
    Some(Vec<u64>),
    /// All of them.
    All,
}

impl Waiting {
    /// Whether the cell `id` waits.
    pub fn holds(&self, id: u64) -> bool {
        match self {
            Waiting::None => false,
            Waiting::Some(ids) => ids.binary_search(&id).is_ok(),
            Waiting::All => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_waits_where_it_is_named_or_all_are() {
        let some = Waiting::Some(vec![2, 5]);
        assert!(some.holds(5) && !some.holds(3) && Waiting::All.holds(3) && !Waiting::None.holds(5));
    }
}
