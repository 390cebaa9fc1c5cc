//! The studies by name, and the tables that they write.

use super::all::all;
use super::arguments::{Arguments, StudyName};
use super::device::device;
use super::fault::{Exit, LabError};
use super::hard::hard;
use super::inertia::inertia;
use super::paper::paper;
use super::solvers::solvers;
use super::work_precision::work_precision;
use super::{compute, output};
use relcp::record::{RecordError, durable};
use relcp::simulation::Compute;
use relcp_lab::StudyError;
use relcp_lab::throughput::{Kind, Row, measure, table};
use serde::Serialize;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The results of a study: its page, its numbers, and whether any result is outside its tolerance.
pub struct Found {
    pub text: String,
    pub numbers: Value,
    pub missed: bool,
    /// Whether it was interrupted and can be continued.
    pub interrupted: bool,
}

pub fn study(arguments: &Arguments) -> Result<Exit, LabError> {
    compute::set_threads(arguments)?;
    if arguments.name != StudyName::Solvers && !arguments.files.is_empty() {
        return Err(LabError::Usage("files are for `relcp-lab solvers`".into()));
    }
    if arguments.name != StudyName::WorkPrecision && arguments.make_references.is_some() {
        return Err(LabError::Usage("--make-references is for `relcp-lab work-precision`".into()));
    }
    if arguments.name != StudyName::Device && !arguments.sizes.is_empty() {
        return Err(LabError::Usage("--sizes is for `relcp-lab device`".into()));
    }
    let drawn = [arguments.random, arguments.confined, arguments.pressed, arguments.chambers];
    if arguments.name != StudyName::Hard && (arguments.lines || drawn.iter().any(Option::is_some)) {
        let message = "`relcp-lab hard` alone has --random, --confined, --pressed, --chambers and --lines";
        return Err(LabError::Usage(message.into()));
    }
    let found = match arguments.name {
        StudyName::All => all(arguments)?,
        name => one(name, arguments)?,
    };
    if arguments.json {
        output::json(&found.numbers)?;
    } else if !arguments.quiet {
        output::write(|out| write!(out, "{}", found.text))?;
    }
    Ok(match (found.interrupted, found.missed) {
        (true, _) => Exit::Interrupted,
        (false, true) => Exit::OutOfTolerance,
        (false, false) => Exit::Done,
    })
}

/// Performs one study. The name in the arguments does not select it, because it may be `all`.
pub fn one(name: StudyName, arguments: &Arguments) -> Result<Found, LabError> {
    match name {
        StudyName::Throughput => throughput(arguments),
        StudyName::Solvers => solvers(arguments),
        StudyName::Hard => hard(arguments),
        StudyName::WorkPrecision => work_precision(arguments),
        StudyName::Inertia => inertia(arguments),
        StudyName::Device => device(arguments),
        name => paper(name, arguments),
    }
}

fn throughput(arguments: &Arguments) -> Result<Found, LabError> {
    let computes = computes(arguments)?;
    let mut rows = Vec::new();
    let kinds = Kind::ALL.into_iter().filter(|kind| arguments.of.is_none_or(|of| of == *kind));
    for kind in kinds {
        for bodies in kind.sizes(arguments.largest).into_iter().filter(|n| *n >= arguments.smallest) {
            for compute in &computes {
                let row = measure(kind, bodies, [arguments.warm_up as usize, arguments.steps as usize], compute)?;
                if !arguments.quiet {
                    let Row { step_ms, computed_by, .. } = &row;
                    output::message(&format!("{kind:?} of {bodies}: {step_ms:.2} ms a step on {computed_by}"));
                }
                rows.push(row);
                // Written after each row, because later rows take longer: an interruption keeps the results.
                write_rows(&rows, arguments)?;
            }
        }
    }
    write_rows(&rows, arguments)?;
    let missed = rows.iter().any(|row| row.unconverged > 0 || row.max_overlap > 1e-5);
    Ok(Found { text: page(&rows, arguments), numbers: value(&rows)?, missed, interrupted: false })
}

/// The page and the numbers of the rows so far.
fn write_rows(rows: &[Row], arguments: &Arguments) -> Result<(), LabError> {
    let (text, numbers) = (page(rows, arguments), pretty(&rows)?);
    write_all(&arguments.out, [("throughput.md", text.as_bytes()), ("throughput.json", &numbers)])
}

/// Returns the CPU, and the device if there is one.
pub fn computes(arguments: &Arguments) -> Result<Vec<Compute>, LabError> {
    let device = compute::beside_the_cpu(arguments, &relcp::Scene::built_in("colony")?)?;
    Ok([Compute::Cpu].into_iter().chain(device).collect())
}

fn page(rows: &[Row], arguments: &Arguments) -> String {
    let Arguments { steps, warm_up, .. } = arguments;
    format!(
        "# Throughput\n\nCopies of a stored colony of 1,024 cells, of a stored jammed compaction of 1,000 ellipsoids and of 1,000 rods packed into a ball, side by side; dt = 0.001, overlap \
         tolerance 1e-5, {steps} steps timed after {warm_up}. \"x copy floor\": an iteration's time over the time in which the device copies the bytes of one product with A. \
         Times are of this machine in this run.\n\n{}",
        table(rows)
    )
}

/// Writes the files of a study into its folder, each atomically.
pub fn write_all<'a>(folder: &Path, files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Result<(), LabError> {
    fs::create_dir_all(folder).map_err(RecordError::io(folder, "create the folder"))?;
    for (name, bytes) in files {
        durable::place(&folder.join(name), bytes)?;
    }
    Ok(())
}

/// Numbers as JSON.
pub fn value<T: Serialize>(of: &T) -> Result<Value, LabError> {
    serde_json::to_value(of).map_err(|e| LabError::Study(StudyError::Table(e.to_string())))
}

/// Numbers as the text of a JSON file.
pub fn pretty<T: Serialize>(of: &T) -> Result<Vec<u8>, LabError> {
    serde_json::to_vec_pretty(of).map_err(|e| LabError::Study(StudyError::Table(e.to_string())))
}
