//! `relcp measure`: measures of a run's states.

use super::arguments::Measure as Arguments;
use super::exit::{CliError, Exit};
use super::watched::watched;
use super::{compute, output};
use relcp::digits::{short, significant};
use relcp::measure::{Document, MeasureError, Measured, Settings, measure as measure_all, measure_last, select, write};
use relcp::record::States;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What `--json` prints: the document with the paths of its files.
#[derive(Serialize)]
struct Printed<'a> {
    folder: &'a Path,
    files: &'a [PathBuf],
    #[serde(flatten)]
    document: Document<'a>,
}

pub(super) fn measure(arguments: &Arguments) -> Result<Exit, CliError> {
    compute::set_thread_count(arguments.threads)?;
    let measures = select(&arguments.only)?;
    let settings = Settings {
        bin: arguments.bin,
        neighbourhood: arguments.neighbourhood,
        domain_angle_degrees: arguments.domain_angle,
        cutoff: arguments.cutoff,
        seed: arguments.seed,
        ..Settings::default()
    };
    let states = States::open(&arguments.run).map_err(MeasureError::from)?;
    let folder = arguments.out.clone().unwrap_or_else(|| place(&arguments.run, states.name()));
    let run = if arguments.last { measure_last } else { measure_all };
    let measured = watched(arguments.print.quiet, |watch| run(&arguments.run, &states, &measures, &settings, watch))?;
    let files = write(&measured, &folder, &arguments.figures.figures)?;
    if arguments.print.json {
        output::json(&Printed { folder: &folder, files: &files, document: Document::new(&measured) })?;
    } else if !arguments.print.quiet {
        print(&measured, &folder, &files)?;
        tell_of_own(&arguments.run)?;
    }
    Ok(Exit::Done)
}

/// In a run's folder, otherwise in the current folder, named after the source.
fn place(run: &Path, name: &str) -> PathBuf {
    if run.is_dir() { run.join("measures") } else { PathBuf::from(format!("{name}-measures")) }
}

/// Says where the measures are that the run itself recorded: they have more rows than there are states.
fn tell_of_own(run: &Path) -> Result<(), CliError> {
    let own = run.join(OWN);
    if !own.is_file() {
        return Ok(());
    }
    output::write(|out| writeln!(out, "  note: the run recorded its own output.measures as it went: {}", own.display()))
}

/// The table of a run's own measures in its folder.
const OWN: &str = "measures.csv";

/// Prints the values of the last state, and the paths of the files with all others.
fn print(measured: &Measured, folder: &Path, files: &[PathBuf]) -> Result<(), CliError> {
    let Some(last) = measured.len().checked_sub(1) else { return Ok(()) };
    let width = measured.columns().map(|column| column.name.len()).max().unwrap_or(0);
    output::write(|out| {
        let (states, bodies) =
            (output::count(measured.len(), "state", "states"), output::count(measured.bodies[last], "body", "bodies"));
        writeln!(out, "{states}; the last, of {bodies} at time {}:", significant(measured.times[last], 12))?;
        for (column, value) in measured.columns().zip(measured.values(last)) {
            if let Some(value) = value {
                writeln!(out, "  {:width$}  {}", column.name, digits(value))?;
            }
        }
        measured.notes.iter().try_for_each(|note| writeln!(out, "  note: {note}"))?;
        writeln!(out, "{} in {}", output::count(files.len(), "file", "files"), folder.display())
    })
}

/// A value with few digits; a count with all digits.
fn digits(value: f64) -> String {
    if value == value.trunc() && value.abs() < 1e15 { value.to_string() } else { short(value) }
}
