//! `relcp-lab work-precision`: the cost of errors, and the references that define errors.

use super::arguments::Arguments;
use super::fault::LabError;
use super::paper::{made, say, size};
use super::study::{Found, computes, value, write_all};
use relcp_lab::work_precision::{PROBLEMS, Reference, Size, Study};
use std::fmt::Write as _;
use std::path::Path;

pub fn work_precision(arguments: &Arguments) -> Result<Found, LabError> {
    if let Some(folder) = &arguments.make_references {
        return make_references(folder, arguments);
    }
    // Before the first measurement, so that an unwritable folder is reported at once.
    write_all(&arguments.out, [])?;
    let study = Study::begin(size(arguments, Size::QUICK, Size::FULL), computes(arguments)?)?;
    made(study, arguments)
}

/// Computes the references again, in the format of the stored ones. It always uses the CPU.
fn make_references(folder: &Path, arguments: &Arguments) -> Result<Found, LabError> {
    write_all(folder, [])?;
    let (mut text, mut references) = (String::new(), Vec::new());
    for problem in PROBLEMS {
        let reference = Reference::make(&problem, problem.making)?;
        let line = format!("{}: two schemes are {:.1e} apart", problem.name, reference.estimate.worst());
        say(arguments, &line);
        let _ = writeln!(text, "{line}");
        // Written after each reference, because together they take minutes.
        write_all(folder, [(&*format!("{}.json", problem.name), reference.text()?.as_bytes())])?;
        references.push(reference);
    }
    Ok(Found { text, numbers: value(&references)?, missed: false, interrupted: false })
}
