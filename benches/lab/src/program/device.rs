//! `relcp-lab device`: measurements of one device.

use super::arguments::{Arguments, Backend, Precision as Wanted};
use super::compute;
use super::fault::LabError;
use super::interrupt::Interrupt;
use super::paper::{plot_files, say, with_plots};
use super::study::{Found, value, write_all};
use relcp::gpu::{Choice, Gpu, Precision};
use relcp_lab::device::{Options, Study, folder_name};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The default folder of studies. The study of a device has its own folder in it.
const TABLES: &str = "studies";

/// Cells of a colony in a quick study, and its number of bodies if no sizes are given.
const QUICK_CELLS: usize = 64;
const QUICK_SIZES: [usize; 1] = [1024];

pub fn device(arguments: &Arguments) -> Result<Found, LabError> {
    if arguments.backend == Backend::Cpu {
        return Err(LabError::Usage("this study is of a device; leave --backend out, or say --backend gpu".into()));
    }
    let interrupt = Interrupt::listen();
    let gpu = open(arguments)?;
    let folder = folder(&arguments.out, &gpu);
    let mut study = Study::open(gpu.clone(), options(arguments, &gpu)?, &folder)?;
    say(arguments, &format!("{} ({}): into {}", gpu.name(), gpu.driver(), folder.display()));
    write(&study, arguments, &folder)?;
    while let Some(said) = study.next_item(&|| !interrupt.asked())? {
        say(arguments, &said);
        write(&study, arguments, &folder)?;
    }
    let text = write(&study, arguments, &folder)?;
    let skipped = study.results().skipped.len();
    if skipped > 0 {
        say(arguments, &format!("{skipped} left out; the same command continues with them"));
    }
    Ok(Found { text, numbers: value(study.results())?, missed: study.missed(), interrupted: interrupt.asked() })
}

/// Opens the named adapter, or the first one, hardware before software.
fn open(arguments: &Arguments) -> Result<Arc<Gpu>, LabError> {
    let choice = Choice { software: true, ..compute::choice(arguments) };
    let gpu = Gpu::open(&choice)?;
    for warning in gpu.warnings() {
        say(arguments, &format!("warning: {warning}"));
    }
    Ok(Arc::new(gpu))
}

/// Returns the given folder, or a folder named after the device.
fn folder(out: &Path, gpu: &Gpu) -> PathBuf {
    if out == Path::new(TABLES) { out.join(folder_name(gpu.name())) } else { out.to_owned() }
}

fn options(arguments: &Arguments, gpu: &Gpu) -> Result<Options, LabError> {
    let precisions = match arguments.precision {
        Some(Wanted::F32) => vec![Precision::F32],
        Some(Wanted::F64) => {
            gpu.check(Precision::F64)?;
            vec![Precision::F64]
        }
        None if gpu.has_f64() => vec![Precision::F32, Precision::F64],
        None => vec![Precision::F32],
    };
    let mut sizes = match (arguments.sizes.is_empty(), arguments.quick) {
        (false, _) => arguments.sizes.clone(),
        (true, true) => QUICK_SIZES.to_vec(),
        (true, false) => Options::sizes(),
    };
    sizes.sort_unstable();
    sizes.dedup();
    let largest = sizes.last().copied().unwrap_or(1);
    Ok(Options {
        precisions,
        time: Duration::try_from_secs_f64(60.0 * arguments.minutes).unwrap_or(Duration::MAX),
        quick: arguments.quick,
        cells: if arguments.quick { largest.min(QUICK_CELLS) } else { largest },
        sizes,
    })
}

/// Writes the page with its plots. The study itself writes its results.
fn write(study: &Study, arguments: &Arguments, folder: &Path) -> Result<String, LabError> {
    let (text, plots) = (study.page(), study.plots()?);
    let page = with_plots(&text, arguments, &plots);
    let plots = plot_files(arguments, &plots)?;
    let files = plots.iter().map(|(name, bytes)| (name.as_str(), &bytes[..]));
    write_all(folder, [("report.md", page.as_bytes())].into_iter().chain(files))?;
    Ok(text)
}
