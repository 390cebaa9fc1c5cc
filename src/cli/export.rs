//! `relcp export`: a run's states in another format.

use super::arguments::{Export as Arguments, ExportFormat};
use super::exit::{CliError, Exit};
use super::watched::watched;
use super::{compute, output};
use relcp::export::{ExportError, Exported, Format, export as write};
use relcp::record::States;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What `--json` prints.
#[derive(Serialize)]
struct Document<'a> {
    format: &'static str,
    folder: &'a Path,
    #[serde(flatten)]
    exported: &'a Exported,
}

pub(super) fn export(arguments: &Arguments) -> Result<Exit, CliError> {
    compute::set_thread_count(arguments.threads)?;
    let (format, extension) = match arguments.format {
        ExportFormat::Gsd => (Format::Gsd, "gsd"),
        ExportFormat::Lammps => (Format::Lammps, "lammps"),
        ExportFormat::Vtk => (Format::Vtk { cutoff: arguments.cutoff }, "vtk"),
        ExportFormat::Xyz => (Format::Xyz, "xyz"),
    };
    if arguments.cutoff.is_some() && arguments.format != ExportFormat::Vtk {
        let usage = format!("--cutoff selects contacts, but {extension} has no contacts; use --format vtk");
        return Err(CliError::Usage(usage));
    }
    let states = States::open(&arguments.run).map_err(ExportError::from)?;
    let states = if arguments.last { states.last() } else { states };
    let folder = arguments.out.clone().unwrap_or_else(|| place(&arguments.run, states.name(), extension));
    let exported = watched(arguments.print.quiet, |watch| write(&states, format, &folder, watch))?;
    if arguments.print.json {
        output::json(&Document { format: extension, folder: &folder, exported: &exported })?;
    } else if !arguments.print.quiet {
        print(&exported)?;
    }
    Ok(Exit::Done)
}

/// In a run's folder, otherwise in the current folder, named after the source.
fn place(run: &Path, name: &str, extension: &str) -> PathBuf {
    if run.is_dir() { run.join(extension) } else { PathBuf::from(format!("{name}-{extension}")) }
}

fn print(exported: &Exported) -> Result<(), CliError> {
    output::write(|out| {
        let (states, bodies) =
            (output::count(exported.states, "state", "states"), output::count(exported.bodies, "body", "bodies"));
        writeln!(out, "{states} of up to {bodies}, {}", output::size(exported.bytes))?;
        exported.files.iter().try_for_each(|file| writeln!(out, "  {}", file.display()))?;
        exported.notes.iter().try_for_each(|note| writeln!(out, "  note: {note}"))
    })
}
