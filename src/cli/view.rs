//! `relcp view`: one HTML file that shows a run in a browser.

use super::arguments::View as Arguments;
use super::compute;
use super::exit::{CliError, Exit};
use super::output;
use super::watched::watched;
use relcp::record::States;
use relcp::render::RenderError;
use relcp::view::{Pages, Viewed, view as write};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The page in a run's folder.
const PAGE: &str = "view.html";

/// What `--json` prints.
#[derive(Serialize)]
struct Document<'a> {
    file: &'a Path,
    #[serde(flatten)]
    viewed: &'a Viewed,
}

pub(super) fn view(arguments: &Arguments) -> Result<Exit, CliError> {
    compute::set_thread_count(arguments.threads)?;
    let states = States::open(&arguments.run).map_err(RenderError::from)?;
    let states = if arguments.which.last { states.last() } else { states };
    let file = arguments.out.clone().unwrap_or_else(|| place(&arguments.run, states.name()));
    let pages = Pages {
        colour: arguments.colour,
        every: arguments.which.every as usize,
        from: arguments.which.from.unwrap_or(f64::NEG_INFINITY),
        to: arguments.which.to.unwrap_or(f64::INFINITY),
    };
    let viewed = watched(arguments.print.quiet, |watch| write(&arguments.run, &states, &pages, &file, watch))?;
    if arguments.print.json {
        output::json(&Document { file: &file, viewed: &viewed })?;
    } else if !arguments.print.quiet {
        print(&file, &viewed)?;
    }
    if arguments.open {
        show(&file);
    }
    Ok(Exit::Done)
}

/// Writes the page of a run that has ended into its folder.
pub(super) fn after(folder: &Path) -> Result<PathBuf, CliError> {
    let states = States::open(folder).map_err(RenderError::from)?;
    let file = folder.join(PAGE);
    write(folder, &states, &Pages::default(), &file, &mut |_, _| true)?;
    Ok(file)
}

/// In a run's folder, otherwise in the current folder, named after the source.
fn place(run: &Path, name: &str) -> PathBuf {
    if run.is_dir() { run.join(PAGE) } else { PathBuf::from(format!("{name}-{PAGE}")) }
}

fn print(file: &Path, viewed: &Viewed) -> Result<(), CliError> {
    output::write(|out| {
        let states = output::count(viewed.states, "state", "states");
        let bodies = output::count(viewed.bodies, "body", "bodies");
        writeln!(out, "{}: {states} of up to {bodies}, {}", file.display(), output::size(viewed.bytes))?;
        viewed.notes.iter().try_for_each(|note| writeln!(out, "  note: {note}"))
    })
}

/// How long to wait for an error from the program that opens files; after that it is assumed to show the file.
const PATIENCE: Duration = Duration::from_secs(3);

/// Asks the system to open the file. If that fails, a message gives the reason; the page itself is complete.
fn show(file: &Path) {
    if let Err(why) = ask_to_show(file) {
        output::message(&format!("could not open a browser: {why}; open {} yourself", file.display()));
    }
}

fn ask_to_show(file: &Path) -> Result<(), String> {
    let program = match (cfg!(target_os = "macos"), cfg!(windows)) {
        (true, _) => "open",
        (_, true) => "explorer",
        _ => "xdg-open",
    };
    let mut command = Command::new(program);
    command.arg(file).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut asked = command.spawn().map_err(|why| format!("`{program}` cannot be started ({why})"))?;
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        match asked.try_wait() {
            // The exit status of Windows' explorer is meaningless.
            Ok(Some(status)) if status.success() || cfg!(windows) => return Ok(()),
            Ok(Some(status)) => return Err(format!("`{program}` found none ({status})")),
            Ok(None) => std::thread::sleep(Duration::from_millis(20)),
            Err(why) => return Err(format!("`{program}` cannot be waited for ({why})")),
        }
    }
    Ok(())
}
