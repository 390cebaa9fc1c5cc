//! `relcp-lab two-ellipsoids`, `jitter`, `chainmail`, `compaction`, `colony` and `packing`: the paper's tests, and
//! similar measurements.

use super::arguments::{Arguments, Backend, StudyName};
use super::fault::LabError;
use super::study::{Found, pretty, value, write_all};
use super::{compute, output};
use relcp::figure::{Figure, Format};
use relcp_lab::StudyError;
use relcp_lab::paper::{COMPUTED_BY, Measured, chainmail, colony, compaction, jitter, packing, two_ellipsoids};
use serde_json::{Value, json};

/// Returns the requested study, or one of them if all are requested.
pub fn paper(name: StudyName, arguments: &Arguments) -> Result<Found, LabError> {
    if arguments.name != StudyName::All {
        on_the_cpu(arguments)?;
    }
    // Before the first measurement, so that an unwritable folder is reported at once.
    write_all(&arguments.out, [])?;
    match name {
        StudyName::Jitter => jitter(arguments),
        StudyName::Chainmail => {
            made(chainmail::Study::begin(size(arguments, chainmail::Size::QUICK, chainmail::Size::FULL)), arguments)
        }
        StudyName::Compaction => {
            made(compaction::Study::begin(size(arguments, compaction::Size::QUICK, compaction::Size::FULL)), arguments)
        }
        StudyName::Colony => {
            made(colony::Study::begin(size(arguments, colony::Size::QUICK, colony::Size::FULL)), arguments)
        }
        StudyName::Packing => {
            made(packing::Study::begin(size(arguments, packing::Size::QUICK, packing::Size::FULL))?, arguments)
        }
        _ => two_ellipsoids(arguments),
    }
}

/// Sub-spheres exist on the CPU only. Nothing is computed on another backend than the requested one.
pub fn on_the_cpu(arguments: &Arguments) -> Result<(), LabError> {
    if arguments.backend == Backend::Gpu {
        return Err(LabError::Usage(
            "this study is computed on the CPU; leave --backend out, or say --backend cpu".into(),
        ));
    }
    compute::cpu(arguments).map(|_| ())
}

pub fn say(arguments: &Arguments, text: &str) {
    if !arguments.quiet {
        output::message(text);
    }
}

pub fn size<S>(arguments: &Arguments, quick: S, full: S) -> S {
    if arguments.quick { quick } else { full }
}

/// Performs a study run by run.
pub fn made(mut study: impl Measured, arguments: &Arguments) -> Result<Found, LabError> {
    let mut found = written(&study, arguments)?;
    while let Some(said) = study.next_run()? {
        say(arguments, &format!("{}: {said}", study.name()));
        // Written after each run, because later runs take longer: an interruption keeps the results.
        found = written(&study, arguments)?;
    }
    let (text, numbers) = found;
    Ok(Found { text, numbers, missed: study.missed(), interrupted: false })
}

fn written(study: &impl Measured, arguments: &Arguments) -> Result<(String, Value), LabError> {
    let (text, numbers, plots) = (study.page(), study.numbers()?, study.plots()?);
    let page = with_plots(&text, arguments, &plots);
    let mut files = study.files()?;
    files.push((format!("{}.md", study.name()), page.into_bytes()));
    files.push((format!("{}.json", study.name()), pretty(&numbers)?));
    files.extend(plot_files(arguments, &plots)?);
    write_all(&arguments.out, files.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])))?;
    Ok((text, numbers))
}

fn two_ellipsoids(arguments: &Arguments) -> Result<Found, LabError> {
    use two_ellipsoids::{Size, Study};
    let size = if arguments.quick { Size::QUICK } else { Size::FULL };
    say(arguments, "two-ellipsoids: the references");
    let mut study = Study::begin(size)?;
    let mut found = written_two_ellipsoids(&study, arguments)?;
    for case in size.cases() {
        study.run(case)?;
        if let Some(row) = study.rows().last() {
            say(arguments, &format!("{}: error {:.1e} in {:.0} ms", case.name(), row.worst, row.milliseconds));
        }
        // Written after each run, because later runs take longer: an interruption keeps the results.
        found = written_two_ellipsoids(&study, arguments)?;
    }
    let (text, numbers) = found;
    Ok(Found { text, numbers, missed: study.missed(), interrupted: false })
}

fn written_two_ellipsoids(study: &two_ellipsoids::Study, arguments: &Arguments) -> Result<(String, Value), LabError> {
    let text = study.page();
    let numbers = json!({
        "computed_by": COMPUTED_BY,
        "size": value(study.size())?,
        "references": value(study.references())?,
        "rows": value(&study.rows())?,
        "targets": value(&study.targets())?,
    });
    let plots = study.plots()?;
    let page = with_plots(&text, arguments, &plots);
    let (json, table) = (pretty(&numbers)?, study.csv()?);
    let files: [(&str, &[u8]); 3] =
        [("two-ellipsoids.md", page.as_bytes()), ("two-ellipsoids.json", &json), ("two-ellipsoids.csv", &table)];
    let plots = plot_files(arguments, &plots)?;
    write_all(&arguments.out, files.into_iter().chain(plots.iter().map(|(name, bytes)| (name.as_str(), &bytes[..]))))?;
    Ok((text, numbers))
}

fn jitter(arguments: &Arguments) -> Result<Found, LabError> {
    use jitter::{Size, Study};
    let size = if arguments.quick { Size::QUICK } else { Size::FULL };
    let mut study = Study::begin(size);
    let mut found = written_jitter(&study, arguments)?;
    for case in size.cases() {
        study.run(case)?;
        if let Some(run) = study.runs().last() {
            let (over, steps) = (run.steps_over, run.steps);
            say(arguments, &format!("{}: {over} of {steps} steps leave too much overlap", case.name()));
        }
        found = written_jitter(&study, arguments)?;
    }
    let (text, numbers) = found;
    Ok(Found { text, numbers, missed: study.missed(), interrupted: false })
}

fn written_jitter(study: &jitter::Study, arguments: &Arguments) -> Result<(String, Value), LabError> {
    let text = study.page();
    let numbers = json!({
        "computed_by": COMPUTED_BY,
        "size": value(study.size())?,
        "runs": value(&study.runs())?,
        "targets": value(&study.targets())?,
    });
    let plots = [("jitter", study.plot()?)];
    let page = with_plots(&text, arguments, &plots);
    let (json, table, steps) = (pretty(&numbers)?, study.csv()?, study.steps_csv()?);
    let files: [(&str, &[u8]); 4] =
        [("jitter.md", page.as_bytes()), ("jitter.json", &json), ("jitter.csv", &table), ("jitter-steps.csv", &steps)];
    let plots = plot_files(arguments, &plots)?;
    write_all(&arguments.out, files.into_iter().chain(plots.iter().map(|(name, bytes)| (name.as_str(), &bytes[..]))))?;
    Ok((text, numbers))
}

/// Returns a page with its plots, as SVG if that format is requested, otherwise in the first requested format.
pub fn with_plots(text: &str, arguments: &Arguments, plots: &[(impl AsRef<str>, Figure)]) -> String {
    let formats = &arguments.figures;
    let shown =
        if formats.contains(&Format::Svg) { Format::Svg } else { formats.first().copied().unwrap_or(Format::Svg) };
    let shown = |(name, _): &(_, _)| format!("\n![]({}.{})", AsRef::<str>::as_ref(name), shown.extension());
    format!("{text}\n## Plots\n{}\n", plots.iter().map(shown).collect::<String>())
}

/// Returns the files of plots, in all requested formats.
pub fn plot_files(
    arguments: &Arguments,
    plots: &[(impl AsRef<str>, Figure)],
) -> Result<Vec<(String, Vec<u8>)>, LabError> {
    let each = plots.iter().flat_map(|plot| arguments.figures.iter().map(move |format| (plot, *format)));
    each.map(|((name, figure), format)| {
        let file = format!("{}.{}", name.as_ref(), format.extension());
        let bytes = figure.file(format).map_err(|what| StudyError::Plot(format!("{file}: {what}")))?;
        Ok((file, bytes))
    })
    .collect()
}
