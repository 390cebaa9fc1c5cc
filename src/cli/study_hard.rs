//! `relcp study hard`: numerical stability on hard cases.

use super::arguments::{Study as Arguments, StudyName};
use super::compute;
use super::exit::CliError;
use super::study::{Found, pretty, value, write_all};
use super::study_paper::{on_the_cpu, say};
use relcp::Scene;
use relcp::simulation::Compute;
use relcp::study::hard::random::{self, Options, Row, Ticket};
use relcp::study::hard::{Size, Study, Verdict, all};
use relcp::study::paper::COMPUTED_BY;
use serde_json::{Value, json};
use std::sync::{Mutex, PoisonError};

pub(super) fn hard(arguments: &Arguments) -> Result<Found, CliError> {
    if arguments.random.is_some() || arguments.confined.is_some() {
        return drawn(arguments);
    }
    if arguments.name != StudyName::All {
        on_the_cpu(arguments)?;
    }
    let size = if arguments.quick { Size::QUICK } else { Size::FULL };
    let mut study = Study::begin(size);
    let mut found = written(&study, arguments)?;
    for case in all() {
        study.run(&case);
        if let Some(row) = study.rows().last() {
            say(arguments, &format!("{}: {}", row.case, row.verdict.name().trim_matches('*')));
        }
        // After each, so that what was run stays when the study is interrupted.
        found = written(&study, arguments)?;
    }
    let (text, numbers) = found;
    Ok(Found { text, numbers, missed: study.missed(), interrupted: false })
}

fn written(study: &Study, arguments: &Arguments) -> Result<(String, Value), CliError> {
    let text = study.page();
    let numbers = json!({
        "computed_by": COMPUTED_BY,
        "size": value(&study.size())?,
        "rows": value(&study.rows())?,
    });
    let (json, table) = (pretty(&numbers)?, study.csv()?);
    let files: [(&str, &[u8]); 3] = [("hard.md", text.as_bytes()), ("hard.json", &json), ("hard.csv", &table)];
    write_all(&arguments.out, files)?;
    Ok((text, numbers))
}

/// Steps of a drawn scene at most where a quick study is asked for.
const QUICK_STEPS: u64 = 20;

/// Scenes drawn from a seed, in place of the cases.
fn drawn(arguments: &Arguments) -> Result<Found, CliError> {
    let compute = compute::settle_many(&arguments.compute, &Scene::built_in("colony")?)?;
    // A device computes one scene after another.
    let (threads, computed_by) = match &compute {
        Compute::Gpu { gpu, precision } => (1, format!("{} {}", gpu.name(), precision.name())),
        _ => (rayon::current_num_threads(), COMPUTED_BY.to_owned()),
    };
    let most_steps = if arguments.quick { QUICK_STEPS } else { u64::MAX };
    let options = Options { seed: arguments.seed, threads, most_steps, compute };
    // Before anything is run, so that a folder that cannot be written to costs nothing.
    write_all(&arguments.out, [])?;
    let tickets = Ticket::of(arguments.random.unwrap_or(0), arguments.confined.unwrap_or(0));
    let fault: Mutex<Option<CliError>> = Mutex::default();
    let rows = random::run_all(&tickets, &options, &|row| {
        say_row(arguments, row);
        // As it ends, so that it stays when the study is interrupted.
        if let Err(error) = write_scene(arguments, row) {
            fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
    })?;
    if let Some(error) = fault.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let text = random::page(&rows, arguments.seed, &computed_by);
    let numbers = json!({ "computed_by": computed_by, "seed": arguments.seed, "rows": value(&rows)? });
    let (json, table) = (pretty(&numbers)?, random::csv(&rows)?);
    let files: [(&str, &[u8]); 3] = [("drawn.md", text.as_bytes()), ("drawn.json", &json), ("drawn.csv", &table)];
    write_all(&arguments.out, files)?;
    Ok(Found { text, numbers, missed: rows.iter().any(|row| row.verdict == Verdict::Fails), interrupted: false })
}

fn say_row(arguments: &Arguments, row: &Row) {
    let why = row.why.first().map_or(String::new(), |against| format!(": {}", against.words));
    say(arguments, &format!("{}: {}{why}", row.name, row.verdict.name().trim_matches('*')));
}

/// Writes the scene of a row that something speaks against, as a file that `relcp run` takes.
fn write_scene(arguments: &Arguments, row: &Row) -> Result<(), CliError> {
    let Some(scene) = &row.scene else { return Ok(()) };
    let (name, text) = (format!("{}.json", row.name), scene.to_json());
    write_all(&arguments.out.join("failures"), [(name.as_str(), text.as_bytes())])
}
