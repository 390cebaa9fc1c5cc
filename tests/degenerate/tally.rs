//! Counts what is wrong and keeps the largest errors, by kind.

use super::oracle::Errors;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What an error may be.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub separation: f64,
    pub normal: f64,
    pub lever: f64,
}

impl Limits {
    /// For a pair of these kinds in 64 bits.
    ///
    /// Of a rod along a ring's axis but for 1e-8 the direction in the ring's plane is rounding, and leans along the rod
    /// by that angle. Deep in each other, a convex body's points are known to the root of a rounding where all normals
    /// round about are nearly as good; those of a thin one move by its aspect ratio as far. Those of superellipsoids
    /// meet where their surfaces are that near.
    pub fn of(kinds: [&str; 2]) -> Limits {
        let normal = if kinds.contains(&"ring") && kinds.contains(&"rod") { 1e-6 } else { 1e-9 };
        let lever = if kinds.iter().all(|kind| matches!(*kind, "sphere" | "rod" | "ring")) {
            1e-9
        } else if kinds.iter().any(|kind| kind.ends_with("super")) {
            1e-4
        } else if kinds.iter().any(|kind| kind.starts_with("thin")) {
            2e-5
        } else {
            1e-7
        };
        Limits { separation: 1e-9, normal, lever }
    }

    fn allow(&self, errors: &Errors) -> bool {
        errors.separation <= self.separation && errors.normal <= self.normal && errors.lever <= self.lever
    }
}

#[derive(Clone, Default)]
struct Count {
    drawn: usize,
    wrong: usize,
    worst: Errors,
    example: String,
}

/// The placements of each kind.
#[derive(Default)]
pub struct Tally(BTreeMap<String, Count>);

impl Tally {
    /// Counts a placement; of the first wrong one of a kind `example` is kept.
    pub fn add(&mut self, kind: &str, errors: Errors, limits: &Limits, example: impl Fn() -> String) {
        let count = self.0.entry(kind.to_owned()).or_default();
        count.drawn += 1;
        count.worst = count.worst.max(errors);
        if !limits.allow(&errors) {
            if count.wrong == 0 {
                count.example = format!("{errors:?} of {}", example());
            }
            count.wrong += 1;
        }
    }

    /// Prints a table, with the examples where `RELCP_EXAMPLES` is set. Returns the kinds that are wrong, and how often.
    pub fn print(&self, what: &str) -> Vec<(&str, usize)> {
        let mut text = format!(
            "\n| {what} | drawn | wrong | separation | normal | levers |\n| --- | ---: | ---: | ---: | ---: | ---: |\n"
        );
        for (kind, count) in &self.0 {
            let Errors { separation, normal, lever } = count.worst;
            let _ = writeln!(
                text,
                "| {kind} | {} | {} | {separation:.0e} | {normal:.0e} | {lever:.0e} |",
                count.drawn, count.wrong
            );
        }
        println!("{text}");
        let wrong: Vec<_> = self.0.iter().filter(|(_, count)| count.wrong > 0).collect();
        if std::env::var_os("RELCP_EXAMPLES").is_some() {
            wrong.iter().for_each(|(kind, count)| println!("{kind}: {}", count.example));
        }
        wrong.into_iter().map(|(kind, count)| (kind.as_str(), count.wrong)).collect()
    }
}

/// Draws of each kind: `RELCP_DEGENERATE`, or so many.
pub fn draws(otherwise: usize) -> usize {
    std::env::var("RELCP_DEGENERATE").ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}
