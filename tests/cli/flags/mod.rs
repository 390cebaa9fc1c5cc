//! Every flag of every command does what its help says: a case for each, and a check that none is missing and none is
//! too many.

mod batch;
mod compute;
mod measure;
mod pictures;
mod run;
mod small;
mod threads;

use super::place::Place;
use super::waiting::comes;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A flag, and what shows that it does what its help says.
pub struct Case {
    command: &'static str,
    flag: &'static str,
    shows: fn(&Place, &str),
}

const fn case(command: &'static str, flag: &'static str, shows: fn(&Place, &str)) -> Case {
    Case { command, flag, shows }
}

const GROUPS: [&[Case]; 5] = [run::CASES, batch::CASES, small::CASES, measure::CASES, pictures::CASES];

/// The command that flags of all commands stand under.
const EVERY: &str = "";
const OF_EVERY: [&str; 2] = ["--help", "--log"];

/// The words that begin lines of a section of a help at an indent of at most so much.
fn words(help: &str, section: &str, most: usize) -> Vec<String> {
    let lines = help.lines().skip_while(|line| *line != section).skip(1).take_while(|line| !line.is_empty());
    let near = lines.filter(|line| line.len() - line.trim_start().len() <= most);
    near.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

/// The flags that a help lists; of descriptions and examples nothing.
fn flags(help: &str) -> BTreeSet<String> {
    let lines = help.lines().take_while(|line| *line != "Examples:");
    let near = lines.filter(|line| line.len() - line.trim_start().len() <= 6);
    let options = near.filter(|line| line.trim_start().starts_with('-'));
    options
        .filter_map(|line| line.split([' ', ',', '[']).find(|word| word.starts_with("--")).map(str::to_owned))
        .collect()
}

fn flags_of_the_program() -> BTreeSet<(String, String)> {
    let place = Place::new();
    let help = place.relcp(&["--help"]).expect(0).out;
    let mut found: BTreeSet<_> = flags(&help).into_iter().map(|flag| (EVERY.to_owned(), flag)).collect();
    for command in words(&help, "Commands:", 2).into_iter().filter(|command| command != "help") {
        let mut of = flags(&place.relcp(&[&command, "--help"]).expect(0).out);
        for flag in OF_EVERY {
            assert!(of.remove(flag), "relcp {command} has no {flag}");
        }
        found.extend(of.into_iter().map(|flag| (command.clone(), flag)));
    }
    found
}

#[test]
fn every_flag_has_a_case_and_every_case_a_flag() {
    let found = flags_of_the_program();
    let cases: Vec<_> =
        GROUPS.into_iter().flatten().map(|case| (case.command.to_owned(), case.flag.to_owned())).collect();
    let distinct: BTreeSet<_> = cases.iter().cloned().collect();
    assert_eq!(distinct.len(), cases.len(), "a flag has two cases");
    assert!(found.len() > 80 && found.contains(&("run".into(), "--resume".into())), "{found:?}");
    let missing: Vec<_> = found.difference(&distinct).collect();
    let gone: Vec<_> = distinct.difference(&found).collect();
    assert!(missing.is_empty() && gone.is_empty(), "without a case: {missing:?}; without a flag: {gone:?}");
}

/// Shows all cases of a group in one place, in which `run` is a run of two rods.
fn show(cases: &[Case]) {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--backend", "cpu", "--quiet", "--out", "run"]).expect(0);
    for case in cases {
        println!("relcp {} {}", case.command, case.flag);
        (case.shows)(&place, case.command);
    }
}

#[test]
fn flags_of_run() {
    show(run::CASES);
}

#[test]
fn flags_of_batch() {
    show(batch::CASES);
}

#[test]
fn flags_of_small_commands() {
    show(small::CASES);
}

#[test]
fn flags_of_measure() {
    show(measure::CASES);
}

#[test]
fn flags_of_pictures() {
    show(pictures::CASES);
}

/// A name that no file of the place has.
fn fresh() -> String {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    format!("out-{}", NEXT.fetch_add(1, Ordering::Relaxed))
}

/// Words of a command that takes moments, and whose files go where they are told.
fn tiny(place: &Place, command: &str, out: &str) -> Vec<String> {
    let line = match command {
        "run" => format!("run rods.json --set time.end=0.1 --backend cpu --out {out}"),
        "batch" => {
            let sweep = r#"{"name": "ends", "scene": "rods.json", "grid": {"time.end": [0.04, 0.06]}}"#;
            std::fs::write(place.at("sweep.json"), sweep).unwrap();
            format!("batch sweep.json --backend cpu --out {out}")
        }
        "check" => "check rods.json".into(),
        "contacts" => "contacts run --cutoff 1 --backend cpu".into(),
        "export" => format!("export run --format xyz --out {out}"),
        "measure" => format!("measure run --out {out}"),
        "render" => format!("render run --size 64x36 --no-movie --backend cpu --out {out}"),
        "view" => format!("view run --out {out}"),
        other => other.into(),
    };
    line.split(' ').map(str::to_owned).collect()
}

/// What a tiny command says with more words.
fn ran(place: &Place, command: &str, more: &[&str]) -> super::ran::Ran {
    let words = tiny(place, command, &fresh());
    place.relcp(&[&words.iter().map(String::as_str).collect::<Vec<_>>(), more].concat())
}

/// What a tiny command prints with more words and `--json`.
fn json(place: &Place, command: &str, more: &[&str]) -> Value {
    let ran = ran(place, command, &[more, &["--json"]].concat());
    serde_json::from_str(&ran.out).unwrap_or_else(|fault| panic!("{fault}: {ran:#?}"))
}

/// `--json`: one document, and nothing else.
fn shows_json(place: &Place, command: &str) {
    let plain = ran(place, command, &[]);
    assert!(serde_json::from_str::<Value>(&plain.out).is_err(), "{plain:#?}");
    assert!(json(place, command, &[]).is_object());
}

/// `--quiet` prints neither progress nor a summary. It prints errors.
fn shows_quiet(place: &Place, command: &str) {
    assert!(!ran(place, command, &[]).out.is_empty());
    let quiet = ran(place, command, &["--quiet"]);
    assert_eq!((&*quiet.out, &*quiet.err), ("", ""));
    let fault = ran(place, command, &["--quiet", "--no-such-flag"]).expect(2);
    assert!(fault.err.contains("--no-such-flag"), "{fault:#?}");
}

/// Whether both files have the same bytes.
fn same(a: &Path, b: &Path) -> bool {
    std::fs::read(a).unwrap() == std::fs::read(b).unwrap()
}
