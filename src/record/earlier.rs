//! Earlier runs in a folder, and which of them can continue.

use super::folder::{Folder, is_numbered};
use serde::Deserialize;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The status of an earlier run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EarlierState {
    /// It was interrupted or killed before its end.
    Unfinished,
    /// It reached its end, or stopped at a failed step.
    Ended,
    /// Another process is writing into its folder.
    Running,
}

/// A run in a folder of runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EarlierRun {
    /// Its folder.
    pub path: PathBuf,
    /// Its status.
    pub state: EarlierState,
}

impl EarlierRun {
    /// The status of the run in a folder; none without a checkpoint.
    pub fn state_of(path: &Path) -> Option<EarlierState> {
        let folder = Folder::view(path);
        last_checkpoint(&folder).map(|changed| state(&folder, changed))
    }

    /// The runs in the folder `parent`, the newest checkpoint first. With a name: only runs of scenes of this name, by
    /// their folders' names ([`Folder::create_in`]). An unreadable folder has no runs.
    pub fn all_in(parent: &Path, name: Option<&str>) -> Vec<EarlierRun> {
        let entries = fs::read_dir(parent).into_iter().flatten().flatten().map(|entry| entry.path());
        let named = entries.filter(|path| name.is_none_or(|name| is_numbered(path, name)));
        let mut found: Vec<(SystemTime, PathBuf)> =
            named.filter_map(|path| Some((last_checkpoint(&Folder::view(&path))?, path))).collect();
        found.sort_by(|a, b| b.cmp(a));
        let runs = found.into_iter().map(|(changed, path)| {
            let state = state(&Folder::view(&path), changed);
            EarlierRun { path, state }
        });
        runs.collect()
    }
}

/// The keys of `summary.json` with the run's status.
#[derive(Deserialize)]
struct Summary {
    status: String,
}

fn modified(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|metadata| metadata.modified()).ok()
}

/// The time of the last checkpoint, or of the previous one after a crash between the two.
fn last_checkpoint(folder: &Folder) -> Option<SystemTime> {
    modified(&folder.checkpoint()).or_else(|| modified(&folder.previous_checkpoint()))
}

fn state(folder: &Folder, checkpoint: SystemTime) -> EarlierState {
    let rows = File::open(folder.steps());
    if rows.is_ok_and(|rows| matches!(rows.try_lock(), Err(TryLockError::WouldBlock))) {
        return EarlierState::Running;
    }
    let path = folder.summary();
    let summary = fs::read(&path).ok().and_then(|bytes| serde_json::from_slice::<Summary>(&bytes).ok());
    // A run that continued past its end, and was killed there, has a checkpoint newer than its summary.
    let is_last = modified(&path).is_some_and(|written| written >= checkpoint);
    match summary {
        Some(summary) if is_last && summary.status != "interrupted" => EarlierState::Ended,
        _ => EarlierState::Unfinished,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// A folder of a run whose checkpoint was written this many seconds after 1970.
    fn run(parent: &Path, name: &str, at: u64, status: Option<&str>) -> Folder {
        let folder = Folder::create_in(parent, name).unwrap();
        let write = |path: PathBuf, text: &str, at| {
            fs::write(&path, text).unwrap();
            File::options().write(true).open(path).unwrap().set_modified(SystemTime::UNIX_EPOCH + at).unwrap();
        };
        let at = Duration::from_secs(at);
        write(folder.steps(), "", at);
        write(folder.checkpoint(), "", at);
        if let Some(status) = status {
            write(folder.summary(), &format!("{{\"status\": \"{status}\", \"steps\": 3}}"), at);
        }
        folder
    }

    #[test]
    fn runs_are_found_the_newest_first_with_how_they_stand() {
        let parent = tempfile::tempdir().unwrap();
        let parent = parent.path();
        assert_eq!(EarlierRun::all_in(&parent.join("absent"), None), []);
        let killed = run(parent, "colony", 20, None);
        run(parent, "colony", 30, Some("done"));
        run(parent, "other", 10, Some("interrupted"));
        run(parent, "colony-like", 5, Some("stopped"));
        fs::create_dir(parent.join("empty")).unwrap();
        let found = |name| {
            let runs = EarlierRun::all_in(parent, name).into_iter();
            runs.map(|run| (run.path.file_name().unwrap().to_str().unwrap().to_owned(), run.state)).collect::<Vec<_>>()
        };
        let [unfinished, ended] = [EarlierState::Unfinished, EarlierState::Ended];
        let own = [("colony-2".to_owned(), ended), ("colony".to_owned(), unfinished)];
        assert_eq!(found(Some("colony")), own);
        assert_eq!(found(None)[2..], [("other".to_owned(), unfinished), ("colony-like".to_owned(), ended)]);
        // It continues past its end.
        let later = SystemTime::UNIX_EPOCH + Duration::from_secs(40);
        let checkpoint = File::options().write(true).open(parent.join("colony-2/checkpoint.npz")).unwrap();
        checkpoint.set_modified(later).unwrap();
        assert_eq!(found(Some("colony"))[0].1, unfinished);
        assert_eq!(EarlierRun::state_of(&parent.join("colony-2")), Some(unfinished));
        assert_eq!(EarlierRun::state_of(&parent.join("empty")), None);
        let held = File::open(killed.steps()).unwrap();
        held.lock().unwrap();
        assert_eq!(found(Some("colony"))[1].1, EarlierState::Running);
    }
}
