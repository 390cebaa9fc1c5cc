//! The run that `relcp run --resume` continues.

use super::arguments::Run as Arguments;
use super::exit::CliError;
use super::run::{RUNS, settle};
use super::{compiling, driver, output};
use relcp::record::{EarlierRun, EarlierState, Folder, RecordError, differing_keys, scene_hash};
use relcp::run::{Run, RunError};
use relcp::scene::{BuiltIn, NO_OVERRIDES, Scene};
use std::path::Path;

/// The command that continues the run in a folder.
pub(super) fn command(folder: &Path) -> String {
    format!("relcp run --resume --out {}", output::argument(folder))
}

/// Resumes the run in `--out`, or one in `runs`: that of the scene if one is named, else the newest.
pub(super) fn resume(arguments: &Arguments) -> Result<Run, CliError> {
    let (folder, scene) = match (&arguments.out, &arguments.scene) {
        (Some(path), source) => {
            let folder = Folder::open(path)?;
            let recorded = folder.scene();
            let scene = Scene::load(source.as_ref().unwrap_or(&recorded), &arguments.sets)?;
            (folder, scene)
        }
        (None, None) => newest(arguments)?,
        (None, Some(source)) => of_scene(arguments, source)?,
    };
    driver::compute_alone(&arguments.compute, &scene, arguments.scene.as_deref());
    let compute = settle(arguments, &scene)?;
    let anew = format!("relcp run --from {}", output::argument(folder.path()));
    let resume = || match arguments.until {
        Some(until) => Run::resume_until(scene, folder, until, &compute),
        None => Run::resume(scene, folder, &compute),
    };
    compiling::watch(&compute, arguments.print.quiet, resume).map_err(|error| match error {
        RunError::Record(damage) if damage.is_damage() => {
            CliError::Damaged { message: damage.to_string(), command: anew }
        }
        error => error.into(),
    })
}

/// The newest unfinished run in `runs`; with `--until`, finished runs count too.
fn newest(arguments: &Arguments) -> Result<(Folder, Scene), CliError> {
    let runs = EarlierRun::all_in(Path::new(RUNS), None);
    let count = |state| runs.iter().filter(|run| run.state == state).count();
    let may_go_on = |run: &&EarlierRun| match run.state {
        EarlierState::Unfinished => true,
        EarlierState::Ended => arguments.until.is_some(),
        EarlierState::Running => false,
    };
    let Some(run) = runs.iter().find(may_go_on) else {
        let elsewhere = "resume a run elsewhere with relcp run --resume --out DIR";
        return Err(CliError::Usage(match (count(EarlierState::Running), count(EarlierState::Ended)) {
            (0, 0) => format!("no run to resume in {RUNS}; {elsewhere}"),
            (0, ended) => format!(
                "no unfinished run in {RUNS}: {} ended; --until TIME continues the newest past its end; {elsewhere}",
                output::count(ended, "run has", "runs have")
            ),
            (running, _) => format!(
                "no unfinished run in {RUNS}, besides {} that another process is computing; {elsewhere}",
                output::count(running, "run", "runs")
            ),
        }));
    };
    say(
        arguments,
        &run.path,
        match count(EarlierState::Unfinished) {
            0 | 1 => String::new(),
            more => format!(", the newest of {more} unfinished runs in {RUNS}"),
        },
    );
    let folder = Folder::open(&run.path)?;
    let scene = Scene::load(folder.scene(), &arguments.sets)?;
    Ok((folder, scene))
}

/// The newest unfinished run of a scene, or else the newest finished one. A run with exactly these settings precedes
/// one with others.
fn of_scene(arguments: &Arguments, source: &Path) -> Result<(Folder, Scene), CliError> {
    let scene = Scene::load(source, &arguments.sets)?;
    let mut runs = EarlierRun::all_in(Path::new(RUNS), Some(&scene.name));
    // Stable: among equals the newest stays first.
    runs.sort_by_key(|run| run.state);
    let Some(first) = runs.first() else { return Err(RecordError::NoCheckpoint { path: RUNS.into() }.into()) };
    let hash = scene_hash(&scene);
    let same = |run: &&EarlierRun| {
        run.state == first.state && Scene::read(run.path.join("scene.json")).is_ok_and(|own| scene_hash(&own) == hash)
    };
    if let Some(run) = runs.iter().find(same) {
        say(arguments, &run.path, String::new());
        return Ok((Folder::open(&run.path)?, scene));
    }
    let folder = Folder::open(&first.path)?;
    // With a later end, the run itself checks that nothing else differs.
    if arguments.until.is_some() {
        return Ok((folder, scene));
    }
    let keys = differing_keys(&folder.scene(), &scene);
    let (path, other) = (first.path.display(), source.display());
    // A built-in scene never changes, so the user meant the run's own settings; a file may have changed since.
    let is_built_in = source.to_str().is_some_and(|name| BuiltIn::named(name).is_some());
    if is_built_in && arguments.sets.is_empty() {
        say(arguments, &first.path, format!(", with its own settings: it differs from {other} in {}", keys.join(", ")));
        let scene = Scene::load(folder.scene(), NO_OVERRIDES)?;
        return Ok((folder, scene));
    }
    Err(CliError::OtherSettings {
        message: format!("{path}: the run in this folder has other settings than {other}: {}", keys.join(", ")),
        command: command(&first.path),
    })
}

fn say(arguments: &Arguments, folder: &Path, what: String) {
    if !arguments.print.quiet {
        output::message(&format!("resuming {}{what}", folder.display()));
    }
}
