//! `relcp study`: measured studies, with their tables.

use super::arguments::{Study, StudyName};
use super::compute;
use super::exit::{CliError, Exit};
use super::output;
use crate::relcp::Compute;
use crate::study::throughput::{Kind, Row, measure, table};
use std::fs;
use std::path::Path;

pub(super) fn study(arguments: &Study) -> Result<Exit, CliError> {
    compute::set_threads(&arguments.compute)?;
    match arguments.name {
        StudyName::Throughput | StudyName::All => throughput(arguments),
    }
}

fn throughput(arguments: &Study) -> Result<Exit, CliError> {
    let device = compute::settle(&arguments.compute, &crate::scene::load("colony", &[])?)?;
    let mut computes = vec![Compute::Cpu];
    computes.extend(matches!(device, Compute::Gpu { .. }).then_some(device));
    let mut rows = Vec::new();
    let kinds = [Kind::Colony, Kind::Compaction].into_iter().filter(|kind| arguments.of.is_none_or(|of| of == *kind));
    for kind in kinds {
        for bodies in kind.sizes(arguments.largest).into_iter().filter(|n| *n >= arguments.smallest) {
            for compute in &computes {
                let row = measure(kind, bodies, [arguments.warm_up as usize, arguments.steps as usize], compute)?;
                if !arguments.print.quiet {
                    let Row { step_ms, computed_by, .. } = &row;
                    output::message(&format!("{kind:?} of {bodies}: {step_ms:.2} ms a step on {computed_by}"));
                }
                rows.push(row);
            }
        }
    }
    let text = page(&rows, arguments);
    write(&arguments.out, &rows, &text)?;
    if arguments.print.json {
        output::json(&rows)?;
    } else if !arguments.print.quiet {
        output::write(|out| write!(out, "{text}"))?;
    }
    let missed = rows.iter().any(|row| row.unconverged > 0 || row.max_overlap > 1e-5);
    Ok(if missed { Exit::OutOfTolerance } else { Exit::Done })
}

fn page(rows: &[Row], arguments: &Study) -> String {
    let Study { steps, warm_up, .. } = arguments;
    format!(
        "# Throughput\n\nCopies of a stored colony of 1,024 cells and of a stored jammed compaction of 1,000 ellipsoids, side by side; dt = 0.001, overlap \
         tolerance 1e-5, {steps} steps timed after {warm_up}. \"x copy floor\": an iteration's time over the time in which the device copies the bytes of one product with A. \
         Times are of this machine in this run.\n\n{}",
        table(rows)
    )
}

fn write(folder: &Path, rows: &[Row], text: &str) -> Result<(), CliError> {
    let failed = |path: &Path| {
        let path = path.display().to_string();
        move |e: std::io::Error| CliError::Study(crate::study::StudyError::Io { path, source: e })
    };
    fs::create_dir_all(folder).map_err(failed(folder))?;
    let page = folder.join("throughput.md");
    fs::write(&page, text).map_err(failed(&page))?;
    let json = folder.join("throughput.json");
    let numbers = serde_json::to_vec_pretty(rows).map_err(|e| failed(&json)(e.into()))?;
    fs::write(&json, numbers).map_err(failed(&json))
}
