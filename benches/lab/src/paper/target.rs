//! What a study is to show, and whether it does.

use serde::Serialize;
use std::fmt::Write as _;

/// How near ratios of rows are to be to the paper's.
pub(super) const WITHIN: f64 = 0.2;

/// What is wanted of a study, and what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// What is wanted.
    pub wanted: String,
    /// What was found.
    pub found: String,
    /// Whether that is it; `None` where it was not measured.
    pub met: Option<bool>,
}

impl Target {
    pub(crate) fn new(wanted: impl Into<String>, found: impl Into<String>, met: Option<bool>) -> Self {
        Target { wanted: wanted.into(), found: found.into(), met }
    }

    /// A target: each number must be at least its bound. The text shows a bound that is not 1; the strings name the
    /// numbers.
    pub(super) fn at_least(wanted: &str, found: &[(String, [f64; 2])]) -> Self {
        let words = found.iter().map(|(whose, [own, bound])| {
            let bound = if *bound == 1.0 { String::new() } else { format!(" of {bound:.1}") };
            format!("{own:.2}{bound} ({whose})")
        });
        let met = (!found.is_empty()).then(|| found.iter().all(|(_, [own, bound])| own >= bound));
        Target::new(wanted, words.collect::<Vec<String>>().join(", "), met)
    }

    /// Each ratio, which is one over the paper's, is to be near 1; the words say whose they are.
    pub(super) fn near(what: &str, ratios: &[(String, f64)]) -> Self {
        let found: Vec<String> = ratios.iter().map(|(whose, ratio)| format!("{ratio:.2} ({whose})")).collect();
        Target::new(
            format!("{what} are within {:.0}% of the paper's: ours over the paper's", 100.0 * WITHIN),
            found.join(", "),
            (!ratios.is_empty()).then(|| ratios.iter().all(|(_, ratio)| is_near(*ratio))),
        )
    }
}

/// Whether a ratio over the paper's is within [`WITHIN`] of 1, above or below.
pub(super) fn is_near(ratio: f64) -> bool {
    ratio.ln().abs() <= (1.0 + WITHIN).ln()
}

/// The targets as a Markdown table.
pub(crate) fn table(targets: &[Target]) -> String {
    let mut out = String::from("| wanted | found | met |\n| --- | --- | --- |\n");
    for Target { wanted, found, met } in targets {
        let met = met.map_or("not measured", |met| if met { "yes" } else { "**no**" });
        let _ = writeln!(out, "| {wanted} | {found} | {met} |");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_to_be_at_least_its_own_bound() {
        let of = |numbers: &[[f64; 2]]| {
            let found: Vec<(String, [f64; 2])> = numbers.iter().map(|pair| ("it".into(), *pair)).collect();
            Target::at_least("wanted", &found)
        };
        assert_eq!(of(&[[2.0, 1.0], [3.5, 3.5]]).found, "2.00 (it), 3.50 of 3.5 (it)");
        assert_eq!([of(&[[2.0, 1.0], [3.5, 3.5]]).met, of(&[[2.0, 1.0], [3.4, 3.5]]).met], [Some(true), Some(false)]);
        assert_eq!(of(&[]).met, None);
        let near = |ratios: &[f64]| Target::near("rows", &ratios.iter().map(|r| ("it".into(), *r)).collect::<Vec<_>>());
        assert_eq!(
            [near(&[1.19, 0.84]).met, near(&[0.83]).met, near(&[1.21]).met],
            [Some(true), Some(false), Some(false)]
        );
        assert_eq!((near(&[]).met, &*near(&[0.5]).found), (None, "0.50 (it)"));
        assert!(table(&[of(&[[0.5, 1.0]]), of(&[])]).contains("| 0.50 (it) | **no** |\n| wanted |  | not measured |"));
    }
}
