//! What a study is to show, and whether it does.

use serde::Serialize;
use std::fmt::Write as _;

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
    pub(super) fn new(wanted: impl Into<String>, found: impl Into<String>, met: Option<bool>) -> Self {
        Target { wanted: wanted.into(), found: found.into(), met }
    }
}

/// The targets as a Markdown table.
pub(super) fn table(targets: &[Target]) -> String {
    let mut out = String::from("| wanted | found | met |\n| --- | --- | --- |\n");
    for Target { wanted, found, met } in targets {
        let met = met.map_or("not measured", |met| if met { "yes" } else { "**no**" });
        let _ = writeln!(out, "| {wanted} | {found} | {met} |");
    }
    out
}
