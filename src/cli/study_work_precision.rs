//! `relcp study work-precision`: what errors cost, and the references that errors are measured against.

use super::arguments::Study as Arguments;
use super::exit::CliError;
use super::study::{Found, computes, value, write_all};
use super::study_paper::{made, say, size};
use relcp::study::work_precision::{PROBLEMS, Reference, Size, Study};
use std::fmt::Write as _;
use std::path::Path;

pub(super) fn work_precision(arguments: &Arguments) -> Result<Found, CliError> {
    if let Some(folder) = &arguments.make_references {
        return make_references(folder, arguments);
    }
    // Before anything is measured, so that a folder that cannot be written to costs nothing.
    write_all(&arguments.out, [])?;
    let study = Study::begin(size(arguments, Size::QUICK, Size::FULL), computes(arguments)?)?;
    made(study, arguments)
}

/// Makes the references anew, as they are stored; on the CPU, whatever else there is.
fn make_references(folder: &Path, arguments: &Arguments) -> Result<Found, CliError> {
    write_all(folder, [])?;
    let (mut text, mut references) = (String::new(), Vec::new());
    for problem in PROBLEMS {
        let reference = Reference::make(&problem, problem.making)?;
        let line = format!("{}: two schemes are {:.1e} apart", problem.name, reference.estimate.worst());
        say(arguments, &line);
        let _ = writeln!(text, "{line}");
        // After each, as together they take minutes.
        write_all(folder, [(&*format!("{}.json", problem.name), reference.text()?.as_bytes())])?;
        references.push(reference);
    }
    Ok(Found { text, numbers: value(&references)?, missed: false, interrupted: false })
}
