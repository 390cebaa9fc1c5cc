//! `all`: every study one after another, each in a folder of its own, and an index of their pages.

use super::arguments::{Arguments, StudyName};
use super::fault::LabError;
use super::paper::say;
use super::study::{Found, one, write_all};
use clap::ValueEnum;
use relcp_lab::machine;
use serde_json::{Map, Value};
use std::fmt::Write as _;
use std::time::{Duration, Instant};

/// The largest number of bodies of the throughput study in quick mode: larger sizes take most of a minute each.
const QUICK_LARGEST: usize = 4096;

/// A completed study.
struct Made {
    name: String,
    about: String,
    found: Found,
    took: Duration,
}

pub fn all(arguments: &Arguments) -> Result<Found, LabError> {
    let mut made: Vec<Made> = Vec::new();
    write(&made, arguments)?;
    for name in alone() {
        let Some(shown) = name.to_possible_value() else { continue };
        let (begun, label) = (Instant::now(), shown.get_name().to_owned());
        let found = one(name, &of(arguments, &label))?;
        let about = shown.get_help().map(ToString::to_string).unwrap_or_default();
        made.push(Made { name: label, about, found, took: begun.elapsed() });
        // The index is written after each study, so that it exists if the rest is interrupted.
        write(&made, arguments)?;
        if let Some(Made { name, took, .. }) = made.last() {
            say(arguments, &format!("{name}: {:.0} s", took.as_secs_f64()));
        }
    }
    let (text, missed) = (index(&made, arguments), made.iter().any(|study| study.found.missed));
    let numbers: Map<String, Value> = made.into_iter().map(|study| (study.name, study.found.numbers)).collect();
    Ok(Found { text, numbers: Value::Object(numbers), missed, interrupted: false })
}

/// Returns the studies of `all`: every study except `all` itself and `device`, which has its own time limit.
fn alone() -> impl Iterator<Item = StudyName> {
    StudyName::value_variants().iter().copied().filter(|name| !matches!(name, StudyName::All | StudyName::Device))
}

/// Returns the arguments of one study.
fn of(arguments: &Arguments, name: &str) -> Arguments {
    let largest = if arguments.quick { arguments.largest.min(QUICK_LARGEST) } else { arguments.largest };
    Arguments { out: arguments.out.join(name), largest, ..arguments.clone() }
}

fn write(made: &[Made], arguments: &Arguments) -> Result<(), LabError> {
    write_all(&arguments.out, [("README.md", index(made, arguments).as_bytes())])
}

fn index(made: &[Made], arguments: &Arguments) -> String {
    let quick = if arguments.quick { " --quick" } else { "" };
    let whole: f64 = made.iter().map(|study| study.took.as_secs_f64()).sum();
    let mut out = format!(
        "# Studies\n\nMade by `cargo run --release -p relcp-lab -- all{quick}`: {} of {} studies in {whole:.0} s. {}.\n\n\
         | study | what it tells | wanted and found | tolerances | seconds |\n| --- | --- | --- | --- | ---: |\n",
        made.len(),
        alone().count(),
        machine()
    );
    for Made { name, about, found, took } in made {
        let held = if found.missed { "**missed**" } else { "held" };
        let seconds = took.as_secs_f64();
        let _ = writeln!(out, "| [{name}]({name}/{name}.md) | {about} | {} | {held} | {seconds:.1} |", wanted(found));
    }
    out
}

/// Returns the number of targets of a study that were reached.
fn wanted(found: &Found) -> String {
    let Some(targets) = found.numbers.get("targets").and_then(Value::as_array) else { return "see its page".into() };
    let count = |met: Value| targets.iter().filter(|target| target["met"] == met).count();
    let (yes, no, unknown) = (count(true.into()), count(false.into()), count(Value::Null));
    let unknown = if unknown > 0 { format!(", {unknown} not measured") } else { String::new() };
    format!("{yes} of {}{unknown}", yes + no)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn made(name: &str, numbers: Value, missed: bool) -> Made {
        let found = Found { text: String::new(), numbers, missed, interrupted: false };
        Made { name: name.into(), about: "about it".into(), found, took: Duration::from_millis(1500) }
    }

    fn arguments(quick: bool) -> Arguments {
        use clap::Parser;
        let words = ["relcp-lab", "all", "--out", "st", "--largest", "9000"];
        Arguments::parse_from(words.into_iter().chain(quick.then_some("--quick")))
    }

    #[test]
    fn the_index_leads_to_every_page_and_counts_what_was_wanted() {
        let targets = json!({ "targets": [{ "met": true }, { "met": false }, { "met": true }, { "met": null }] });
        let page = index(&[made("jitter", targets, false), made("solvers", json!({}), true)], &arguments(true));
        assert!(page.contains("`cargo run --release -p relcp-lab -- all --quick`: 2 of 11 studies in 3 s."), "{page}");
        assert!(
            page.contains("| [jitter](jitter/jitter.md) | about it | 2 of 3, 1 not measured | held | 1.5 |"),
            "{page}"
        );
        assert!(
            page.contains("| [solvers](solvers/solvers.md) | about it | see its page | **missed** | 1.5 |"),
            "{page}"
        );
    }

    #[test]
    fn each_study_has_a_folder_and_quick_ones_are_small() {
        let quick = of(&arguments(true), "packing");
        assert_eq!((quick.out, quick.largest), ("st/packing".into(), QUICK_LARGEST));
        assert_eq!(of(&arguments(false), "packing").largest, 9000);
        assert!(StudyName::value_variants().iter().all(|name| name.to_possible_value().unwrap().get_help().is_some()));
    }
}
