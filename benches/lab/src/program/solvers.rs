//! `relcp-lab solvers`: every solver on stored LCPs and on short runs.

use super::arguments::Arguments;
use super::fault::LabError;
use super::output;
use super::paper::{plot_files, with_plots};
use super::study::{Found, computes, pretty, value, write_all};
use relcp::figure::Figure;
use relcp::lcp::Status;
use relcp::record::{Folder, RecordError, read_lcp};
use relcp_lab::StudyError;
use relcp_lab::solvers::{
    Attempt, Instance, Named, RunRow, Size, attempts_csv, built_in, measure, page, plot, run_cases, runs_csv,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The largest relative difference between the residual that a solver reports and the recomputed one, which sum in
/// different orders. It does not apply to devices, whose precision is lower.
const ROUNDING: f64 = 1e-6;

pub fn solvers(arguments: &Arguments) -> Result<Found, LabError> {
    let size = if arguments.quick { Size::QUICK } else { Size::FULL };
    // Before the first measurement, so that an unreadable file is reported at once.
    let lcps = if arguments.files.is_empty() { built_in().map_err(StudyError::from)? } else { read(&arguments.files)? };
    let computes = computes(arguments)?;
    write_all(&arguments.out, [])?;
    let say = |text: String| {
        if !arguments.quiet {
            output::message(&text);
        }
    };
    let mut instances = Vec::new();
    for lcp in &lcps {
        say(format!("{}: {} rows", lcp.name, lcp.lcp.q.len()));
        instances.push(measure(lcp, &computes, &size).map_err(StudyError::from)?);
        // Written after each LCP, so that an interruption keeps the results.
        written(&size, &instances, &[], arguments)?;
    }
    let runs = if arguments.files.is_empty() {
        run_cases(&size, &computes, |row| {
            say(format!("{} by {}: {:.0} products a step", row.run, row.solver, row.products))
        })?
    } else {
        Vec::new()
    };
    let (text, numbers) = written(&size, &instances, &runs, arguments)?;
    let missed = instances.iter().flat_map(|instance| &instance.attempts).any(false_claim);
    Ok(Found { text, numbers, missed, interrupted: false })
}

/// Writes the results so far: the page without its plots, and the numbers.
fn written(
    size: &Size,
    instances: &[Instance],
    runs: &[RunRow],
    arguments: &Arguments,
) -> Result<(String, Value), LabError> {
    let text = page(instances, runs, size);
    let numbers = json!({ "size": size, "lcps": value(&instances)?, "runs": value(&runs)? });
    let plots = instances.iter().map(|instance| Ok((plot_name(instance), plot(instance)?)));
    let plots = plots.collect::<Result<Vec<(String, Figure)>, StudyError>>()?;
    let (page, table) = (with_plots(&text, arguments, &plots), attempts_csv(instances)?);
    let (json, runs) = (pretty(&numbers)?, runs_csv(runs)?);
    let mut files = vec![("solvers.md", page.as_bytes()), ("solvers.json", &json[..]), ("solvers.csv", &table[..])];
    if !runs.is_empty() {
        files.push(("solvers-runs.csv", &runs[..]));
    }
    let plots = plot_files(arguments, &plots)?;
    files.extend(plots.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])));
    write_all(&arguments.out, files)?;
    Ok((text, numbers))
}

/// Returns whether a solve on the CPU reports a residual that it did not reach.
fn false_claim(attempt: &Attempt) -> bool {
    let attained = attempt.residual.is_some_and(|residual| residual <= attempt.tolerance * (1.0 + ROUNDING));
    attempt.computed_by.starts_with("CPU") && attempt.status == Status::Solved.name() && !attained
}

fn plot_name(instance: &Instance) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '.' { c } else { '_' };
    format!("solvers-{}", instance.lcp.chars().map(plain).collect::<String>())
}

/// Reads the LCPs of files, of folders with such files, and of runs, each with its name. Repeated names are numbered.
fn read(paths: &[PathBuf]) -> Result<Vec<Named>, LabError> {
    let mut lcps: Vec<Named> = Vec::new();
    for path in paths {
        let files = if path.is_dir() { in_folder(path)? } else { vec![path.clone()] };
        for file in files {
            let (lcp, _) = read_lcp(&file)?;
            let stem = file.file_stem().map_or("lcp".into(), |stem| stem.to_string_lossy().into_owned());
            let taken = |name: &str| lcps.iter().any(|lcp| lcp.name == name);
            let numbered = (2_u64..).map(|n| format!("{stem}-{n}"));
            let name = std::iter::once(stem.clone()).chain(numbered).find(|name| !taken(name)).unwrap_or_default();
            lcps.push(Named { name, lcp });
        }
    }
    Ok(lcps)
}

fn in_folder(path: &Path) -> Result<Vec<PathBuf>, LabError> {
    let run = Folder::view(path);
    let is_run = run.scene().is_file();
    let folder = if is_run || run.lcps().is_dir() { run.lcps() } else { path.to_owned() };
    let mut files = if is_run && !folder.exists() { Vec::new() } else { listed(&folder)? };
    files.retain(|file| file.extension().is_some_and(|extension| extension == "npz"));
    files.sort();
    match files.is_empty() {
        false => Ok(files),
        true if is_run => Err(LabError::Usage(format!(
            "{}: no LCP of this run was saved: its scene has no solver.dump, or no solve met it; run the scene again \
             with --set solver.dump.when=all, or =slow for the slow solves only",
            path.display()
        ))),
        true => Err(LabError::Usage(format!("{}: there is no .npz in it", folder.display()))),
    }
}

fn listed(folder: &Path) -> Result<Vec<PathBuf>, LabError> {
    let fault = || RecordError::io(folder, "list it");
    let entries = std::fs::read_dir(folder).map_err(fault())?.collect::<Result<Vec<_>, _>>().map_err(fault())?;
    Ok(entries.into_iter().map(|entry| entry.path()).collect())
}
