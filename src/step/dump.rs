//! Which LCPs of a run are saved into its folder, for a look at a solver that does not get on.

/// Products from which on a solve counts as slow, where a scene does not say: the default solver needs 1,052 at most
/// for stored systems of a colony of 1,024 cells at 1e-6, and 1,539 for one of 4,096.
const SLOW_PRODUCTS: u64 = 2_000;

/// LCPs saved of one run, where a scene does not say: enough to see whether they are alike.
const MOST: u32 = 10;

/// The limit on saved LCPs: each is a file of some 100 bytes a row.
pub(crate) const MOST_DUMPED: u32 = 10_000;

/// The LCPs of a run to save into its folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Dump {
    /// The solves to save.
    pub when: DumpWhen,
    /// The number of products from which a solve counts as slow; for `slow` only. Without it: 2,000.
    #[cfg_attr(feature = "files", schemars(range(min = 1)), serde(default, skip_serializing_if = "Option::is_none"))]
    pub products: Option<u64>,
    /// The limit on saved LCPs; the first ones are saved. Without it: 10.
    #[cfg_attr(feature = "files", schemars(range(min = 1, max = 10_000)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub most: Option<u32>,
}

/// The solves to save.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum DumpWhen {
    /// Solves that did not reach the tolerance.
    Unconverged,
    /// These, and solves that took many products.
    Slow,
    /// All.
    All,
}

impl Dump {
    /// The solves of this kind, the rest by default.
    pub const fn new(when: DumpWhen) -> Dump {
        Dump { when, products: None, most: None }
    }

    /// Most LCPs that are saved.
    pub fn at_most(&self) -> usize {
        self.most.unwrap_or(MOST) as usize
    }

    /// Whether a solve is saved.
    pub fn wants(&self, solved: bool, products: u64) -> bool {
        match self.when {
            DumpWhen::Unconverged => !solved,
            DumpWhen::Slow => !solved || products >= self.products.unwrap_or(SLOW_PRODUCTS),
            DumpWhen::All => true,
        }
    }

    /// This with its defaults written out.
    pub(crate) fn with_defaults(self) -> Dump {
        let products = (self.when == DumpWhen::Slow).then(|| self.products.unwrap_or(SLOW_PRODUCTS));
        Dump { products, most: Some(self.most.unwrap_or(MOST)), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_when_wants_what_it_says() {
        let wants = |when, products: Option<u64>| {
            let dump = Dump { when, products, most: None };
            [(true, 5), (true, 5_000), (false, 5)].map(|(solved, products)| dump.wants(solved, products))
        };
        assert_eq!(wants(DumpWhen::Unconverged, None), [false, false, true]);
        assert_eq!(wants(DumpWhen::Slow, None), [false, true, true]);
        assert_eq!(wants(DumpWhen::Slow, Some(5)), [true, true, true]);
        assert_eq!(wants(DumpWhen::All, None), [true; 3]);
    }

    #[test]
    fn defaults_are_written_out_where_they_count() {
        let dump = |when| Dump { when, products: None, most: None }.with_defaults();
        assert_eq!(dump(DumpWhen::All), Dump { when: DumpWhen::All, products: None, most: Some(MOST) });
        assert_eq!(dump(DumpWhen::Slow).products, Some(SLOW_PRODUCTS));
    }
}
