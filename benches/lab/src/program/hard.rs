//! `relcp-lab hard`: numerical stability on hard cases.

use super::arguments::{Arguments, StudyName};
use super::compute;
use super::fault::LabError;
use super::paper::{on_the_cpu, say};
use super::study::{Found, pretty, value, write_all};
use relcp::Scene;
use relcp::simulation::Compute;
use relcp_lab::hard::random::{self, Options, Row, Ticket};
use relcp_lab::hard::{Size, Study, Verdict, all, chambers, lines};
use relcp_lab::paper::COMPUTED_BY;
use serde_json::{Value, json};
use std::sync::{Mutex, PoisonError};

pub fn hard(arguments: &Arguments) -> Result<Found, LabError> {
    if [arguments.random, arguments.confined, arguments.pressed].iter().any(Option::is_some) {
        return drawn(arguments);
    }
    if let Some(count) = arguments.chambers {
        return chambers(arguments, count);
    }
    if arguments.lines {
        return lines(arguments);
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
        // Written after each case, so that an interruption keeps the results.
        found = written(&study, arguments)?;
    }
    let (text, numbers) = found;
    Ok(Found { text, numbers, missed: study.missed(), interrupted: false })
}

fn written(study: &Study, arguments: &Arguments) -> Result<(String, Value), LabError> {
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

/// The largest number of steps of a drawn scene in quick mode.
const QUICK_STEPS: u64 = 20;

/// Runs scenes drawn from a seed instead of the cases.
fn drawn(arguments: &Arguments) -> Result<Found, LabError> {
    let compute = compute::settle_many(arguments, &Scene::built_in("colony")?)?;
    // A device computes one scene after another.
    let (threads, computed_by) = match &compute {
        Compute::Gpu { gpu, precision } => (1, format!("{} {}", gpu.name(), precision.name())),
        _ => (rayon::current_num_threads(), COMPUTED_BY.to_owned()),
    };
    let most_steps = if arguments.quick { QUICK_STEPS } else { u64::MAX };
    let options =
        Options { seed: arguments.seed, threads, most_steps, rough: arguments.friction, keys: arguments.keys, compute };
    // Before the first run, so that an unwritable folder is reported at once.
    write_all(&arguments.out, [])?;
    let counts = [arguments.random, arguments.confined, arguments.pressed];
    let tickets = Ticket::of(counts.map(|count| count.unwrap_or(0)), arguments.first);
    let faults = Faults::default();
    let rows = random::run_all(&tickets, &options, &|row| {
        say_row(arguments, row);
        // Written when the scene ends, so that an interruption keeps it.
        if let Some(scene) = &row.scene {
            faults.keep(write_scene(arguments, scene));
        }
    })?;
    faults.first()?;
    let text = random::page(&rows, arguments.seed, &more_flags(arguments), &computed_by);
    let numbers = json!({ "computed_by": computed_by, "seed": arguments.seed, "rows": value(&rows)? });
    let (json, table) = (pretty(&numbers)?, random::csv(&rows)?);
    let files: [(&str, &[u8]); 3] = [("drawn.md", text.as_bytes()), ("drawn.json", &json), ("drawn.csv", &table)];
    write_all(&arguments.out, files)?;
    Ok(Found { text, numbers, missed: rows.iter().any(|row| row.verdict == Verdict::Fails), interrupted: false })
}

/// The flags that draw these scenes again, beside their numbers.
fn more_flags(arguments: &Arguments) -> String {
    let mut flags = format!("--seed {}", arguments.seed);
    if arguments.first > 0 {
        flags.push_str(&format!(" --first {}", arguments.first));
    }
    for (given, flag) in
        [(arguments.friction, " --friction"), (arguments.keys, " --keys"), (arguments.quick, " --quick")]
    {
        flags.push_str(if given { flag } else { "" });
    }
    flags
}

fn say_row(arguments: &Arguments, row: &Row) {
    let why = row.why.first().map_or(String::new(), |against| format!(": {}", against.words));
    say(arguments, &format!("{}: {}{why}", row.name, row.verdict.name().trim_matches('*')));
}

/// Writes a scene with findings as a file for `relcp run`.
fn write_scene(arguments: &Arguments, scene: &Scene) -> Result<(), LabError> {
    let (name, text) = (format!("{}.json", scene.name), scene.to_json());
    write_all(&arguments.out.join("failures"), [(name.as_str(), text.as_bytes())])
}

/// The first error while rows were reported, on any thread.
#[derive(Default)]
struct Faults(Mutex<Option<LabError>>);

impl Faults {
    fn keep(&self, written: Result<(), LabError>) {
        if let Err(error) = written {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
    }

    fn first(self) -> Result<(), LabError> {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }
}

/// Runs growth chambers instead of the cases.
fn chambers(arguments: &Arguments, count: u64) -> Result<Found, LabError> {
    on_the_cpu(arguments)?;
    write_all(&arguments.out, [])?;
    let (seed, stalls) = (arguments.seed, arguments.stall);
    let most_steps = if arguments.quick { QUICK_STEPS } else { u64::MAX };
    let faults = Faults::default();
    let rows = chambers::run_all([seed, count], stalls, most_steps, rayon::current_num_threads(), &|row, chamber| {
        let (name, ended) = (&chamber.scene.name, row.end.name());
        say(arguments, &format!("{name}: {ended} at {:.2}, largest move {:.2}", row.time, row.largest_move));
        if !row.is_well() {
            faults.keep(write_scene(arguments, &chamber.scene));
        }
    })?;
    faults.first()?;
    let text = chambers::page(&rows, seed, stalls);
    let numbers = json!({ "computed_by": COMPUTED_BY, "seed": seed, "stalls": stalls, "rows": value(&rows)? });
    let (json, table) = (pretty(&numbers)?, chambers::csv(&rows)?);
    let files: [(&str, &[u8]); 3] =
        [("chambers.md", text.as_bytes()), ("chambers.json", &json), ("chambers.csv", &table)];
    write_all(&arguments.out, files)?;
    Ok(Found { text, numbers, missed: !rows.iter().all(chambers::Row::is_well), interrupted: false })
}

/// Runs bodies in line instead of the cases.
fn lines(arguments: &Arguments) -> Result<Found, LabError> {
    on_the_cpu(arguments)?;
    write_all(&arguments.out, [])?;
    let size = if arguments.quick { Size::QUICK } else { Size::FULL };
    let rows = lines::run_all(&lines::all(size), size, rayon::current_num_threads(), &|rows| {
        let well = rows.iter().filter(|row| row.is_well()).count();
        let what = rows.first().map_or(String::new(), |row| row.line.what());
        say(arguments, &format!("{what}: {well} of {} are well", rows.len()));
    })?;
    let text = lines::page(&rows);
    let numbers = json!({ "computed_by": COMPUTED_BY, "size": value(&size)?, "rows": value(&rows)? });
    let (json, table) = (pretty(&numbers)?, lines::csv(&rows)?);
    let files: [(&str, &[u8]); 3] = [("lines.md", text.as_bytes()), ("lines.json", &json), ("lines.csv", &table)];
    write_all(&arguments.out, files)?;
    Ok(Found { text, numbers, missed: !rows.iter().all(lines::Row::is_well), interrupted: false })
}
