//! A run's folder: its files, and the name of a new folder.

use super::durable;
use super::error::RecordError;
use std::fs::{self, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The largest number of bytes of a scene's name in its folder's name; file systems allow about 255 bytes.
const LONGEST_NAME: usize = 100;

/// The folder of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folder(PathBuf);

impl Folder {
    /// The folder `path`, unchanged; it may not exist.
    pub(crate) fn at(path: &Path) -> Self {
        Folder(path.into())
    }

    /// Creates the folder `path` for a new run. An existing folder must be empty.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        match fs::read_dir(path) {
            Ok(mut entries) => {
                if entries.next().is_some() {
                    return Err(RecordError::NotEmpty { path: path.into() });
                }
            }
            Err(e) if e.kind() == ErrorKind::NotFound => {
                fs::create_dir_all(path).map_err(RecordError::io(path, "create the folder"))?;
            }
            Err(e) => return Err(RecordError::io(path, "use it as a folder")(e)),
        }
        Folder(path.into()).with_states()
    }

    /// Creates a new folder in `parent`, named after the scene `name`: `NAME`, or `NAME-2`, `NAME-3`, ... if that
    /// exists.
    pub fn create_in(parent: &Path, name: &str) -> Result<Self, RecordError> {
        fs::create_dir_all(parent).map_err(RecordError::io(parent, "create the folder"))?;
        for path in candidates(parent, name) {
            match fs::create_dir(&path) {
                Ok(()) => return Folder(path).with_states(),
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
                Err(e) => return Err(RecordError::io(&path, "create the folder")(e)),
            }
        }
        Err(RecordError::NotEmpty { path: parent.into() })
    }

    fn with_states(self) -> Result<Self, RecordError> {
        let states = self.states();
        fs::create_dir_all(&states).map_err(RecordError::io(&states, "create the folder"))?;
        Ok(self)
    }

    /// The folder of an earlier run; removes temporary files of a crash.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let folder = Folder(path.into());
        if !folder.checkpoint().exists() && !folder.previous_checkpoint().exists() {
            return Err(RecordError::NoCheckpoint { path: path.into() });
        }
        folder.with_states()
    }

    /// The folder of an earlier run, read-only: nothing is created or removed, and it may not exist.
    pub fn view(path: &Path) -> Self {
        Folder(path.into())
    }

    /// The recorded states by step, in order.
    pub fn recorded(&self) -> Result<Vec<(u64, PathBuf)>, RecordError> {
        let states = self.states();
        let mut found = Vec::new();
        let entries = match fs::read_dir(&states) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(found),
            entries => entries.map_err(RecordError::io(&states, "list it"))?,
        };
        for entry in entries {
            let path = entry.map_err(RecordError::io(&states, "list it"))?.path();
            found.extend(step_of(&path).map(|step| (step, path)));
        }
        found.sort();
        Ok(found)
    }

    /// Empties the folder of a run that stopped before its first checkpoint, for a new start. Refused if anything else
    /// is in it.
    ///
    /// # Errors
    /// [`RecordError::InUse`] if a run is starting in it, [`RecordError::NotEmpty`] if it contains other files.
    pub fn restart(path: &Path) -> Result<Self, RecordError> {
        let folder = Folder(path.into()).with_states()?;
        let rows = folder.steps();
        // Locked until the file is removed, so that only one of two restarts succeeds.
        let held = fs::File::open(&rows).ok();
        if held.as_ref().is_some_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock))) {
            return Err(RecordError::InUse { path: path.into() });
        }
        durable::sweep(path)?;
        durable::sweep(&folder.states())?;
        let own = [folder.scene(), rows, folder.measures(), folder.lineage(), folder.states()];
        let states = list(&folder.states())?;
        let foreign = list(path)?.iter().any(|entry| !own.contains(entry));
        if foreign || states.iter().any(|state| step_of(state) != Some(0)) {
            return Err(RecordError::NotEmpty { path: path.into() });
        }
        for file in states.iter().chain(&own[..4]).filter(|file| file.exists()) {
            fs::remove_file(file).map_err(RecordError::io(file, "remove it"))?;
        }
        Ok(folder)
    }

    /// The number of saved LCPs.
    pub(crate) fn count_lcps(&self) -> Result<usize, RecordError> {
        let folder = self.lcps();
        if !folder.exists() {
            return Ok(0);
        }
        Ok(list(&folder)?.iter().filter(|path| lcp_of(path).is_some()).count())
    }

    fn rewind_lcps(&self, step: u64) -> Result<(), RecordError> {
        let folder = self.lcps();
        if !folder.exists() {
            return Ok(());
        }
        durable::sweep(&folder)?;
        for path in list(&folder)?.iter().filter(|path| lcp_of(path).is_some_and(|of| of > step)) {
            fs::remove_file(path).map_err(RecordError::io(path, "remove it"))?;
        }
        Ok(())
    }

    /// Removes temporary files of a crash, and the states and LCPs of steps after `step`.
    pub(crate) fn rewind(&self, step: u64) -> Result<(), RecordError> {
        durable::sweep(&self.0)?;
        self.rewind_lcps(step)?;
        let states = self.states();
        durable::sweep(&states)?;
        for entry in fs::read_dir(&states).map_err(RecordError::io(&states, "list it"))? {
            let path = entry.map_err(RecordError::io(&states, "list it"))?.path();
            if step_of(&path).is_some_and(|of| of > step) {
                fs::remove_file(&path).map_err(RecordError::io(&path, "remove it"))?;
            }
        }
        Ok(())
    }

    /// The folder itself.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The scene of the run, with every default written out.
    pub fn scene(&self) -> PathBuf {
        self.0.join("scene.json")
    }

    /// `steps.csv`: one row per recorded step.
    pub fn steps(&self) -> PathBuf {
        self.0.join("steps.csv")
    }

    /// The scene's measures, one row for each recorded step.
    pub fn measures(&self) -> PathBuf {
        self.0.join("measures.csv")
    }

    /// The lives that ended, if the scene removes bodies.
    pub fn lineage(&self) -> PathBuf {
        self.0.join("lineage.csv")
    }

    /// The folder of the states over time.
    pub fn states(&self) -> PathBuf {
        self.0.join("states")
    }

    /// The state after step `step`.
    pub fn state(&self, step: u64) -> PathBuf {
        self.states().join(format!("state_{step:010}.npz"))
    }

    /// The folder of the LCPs that the scene selects.
    pub fn lcps(&self) -> PathBuf {
        self.0.join("lcps")
    }

    /// The LCP of step `step`, from 1, after `recursion` recursions.
    pub fn lcp(&self, step: u64, recursion: u32) -> PathBuf {
        self.lcps().join(format!("step-{step:06}-rec-{recursion}.npz"))
    }

    /// The checkpoint to continue from.
    pub fn checkpoint(&self) -> PathBuf {
        self.0.join("checkpoint.npz")
    }

    /// The previous checkpoint, in case the last one is damaged.
    pub fn previous_checkpoint(&self) -> PathBuf {
        self.0.join("checkpoint.previous.npz")
    }

    /// The state of another run that this one began with, if it did.
    pub fn parent(&self) -> PathBuf {
        self.0.join("from.json")
    }

    /// The final state, as a scene.
    pub fn last(&self) -> PathBuf {
        self.0.join("final.json")
    }

    /// A picture of the run's last state.
    pub fn picture(&self) -> PathBuf {
        self.0.join("final.png")
    }

    /// The summary of the run.
    pub fn summary(&self) -> PathBuf {
        self.0.join("summary.json")
    }
}

/// The step of an LCP's file; none for other files.
fn lcp_of(path: &Path) -> Option<u64> {
    let name = path.file_name()?.to_str()?;
    let (step, recursion) = name.strip_prefix("step-")?.strip_suffix(".npz")?.split_once("-rec-")?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (digits(step) && digits(recursion)).then(|| step.parse().ok())?
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let entries = fs::read_dir(folder).map_err(RecordError::io(folder, "list it"))?;
    entries.map(|entry| Ok(entry.map_err(RecordError::io(folder, "list it"))?.path())).collect()
}

fn step_of(path: &Path) -> Option<u64> {
    path.file_name()?.to_str()?.strip_prefix("state_")?.strip_suffix(".npz")?.parse().ok()
}

fn candidates(parent: &Path, name: &str) -> impl Iterator<Item = PathBuf> {
    let name = folder_name(name);
    let parent = parent.to_owned();
    (1_u64..).map(move |n| parent.join(if n == 1 { name.clone() } else { format!("{name}-{n}") }))
}

/// Whether a folder has the name that [`Folder::create_in`] gives for a scene of this name.
pub(super) fn is_numbered(path: &Path, name: &str) -> bool {
    let own = path.file_name().and_then(|own| own.to_str());
    let Some(rest) = own.and_then(|own| own.strip_prefix(folder_name(name).as_str())) else { return false };
    rest.is_empty() || rest.strip_prefix('-').is_some_and(|n| n.parse::<u64>().is_ok_and(|n| n > 1))
}

/// A scene's name as a valid folder name on any system; letters and digits of any language are kept.
pub(crate) fn folder_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let whole = name.char_indices().take_while(|(at, c)| at + c.len_utf8() <= LONGEST_NAME);
    let name: String = whole.map(|(_, c)| plain(c)).collect();
    let name = name.trim_matches(['-', '.']);
    if name.is_empty() { "run".into() } else { name.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_fit_for_folders() {
        for (name, folder) in [
            ("colony", "colony"),
            ("two rods/..", "two-rods"),
            ("../../etc", "etc"),
            ("", "run"),
            ("...", "run"),
            ("\u{e9}", "\u{e9}"),
            ("sweep \u{f6}", "sweep-\u{f6}"),
            ("\u{1f600}", "run"),
            (&"\u{4e2d}".repeat(90), &"\u{4e2d}".repeat(33)),
        ] {
            assert_eq!(folder_name(name), folder);
        }
    }

    #[test]
    fn a_taken_name_is_numbered() {
        let parent = tempfile::tempdir().unwrap();
        for expected in ["a", "a-2", "a-3"] {
            let made = Folder::create_in(parent.path(), "a").unwrap();
            assert_eq!(made.path(), parent.path().join(expected));
        }
    }

    #[test]
    fn an_empty_folder_is_taken_and_a_full_one_refused() {
        let parent = tempfile::tempdir().unwrap();
        Folder::create(parent.path()).unwrap();
        let refused = Folder::create(parent.path()).unwrap_err();
        assert!(matches!(refused, RecordError::NotEmpty { .. }));
    }

    #[test]
    fn states_are_listed_by_step() {
        let parent = tempfile::tempdir().unwrap();
        let folder = Folder::view(&parent.path().join("run"));
        assert_eq!(folder.recorded().unwrap(), []);
        assert!(!folder.path().exists());
        let folder = Folder::create(folder.path()).unwrap();
        fs::write(folder.states().join("mine.txt"), b"note").unwrap();
        let steps = [9, 0, 12_345_678_901, 10];
        for step in steps {
            durable::write(&folder.state(step), b"x").unwrap();
        }
        let listed: Vec<u64> = folder.recorded().unwrap().into_iter().map(|(step, _)| step).collect();
        assert_eq!(listed, [0, 9, 10, 12_345_678_901]);
    }

    #[test]
    fn a_folder_without_a_checkpoint_is_emptied_and_others_are_not() {
        let parent = tempfile::tempdir().unwrap();
        let path = parent.path().join("run");
        let folder = Folder::create(&path).unwrap();
        let fill = || {
            for file in [folder.scene(), folder.steps(), folder.measures(), folder.state(0), path.join(".relcp-x.part")]
            {
                fs::write(file, b"x").unwrap();
            }
        };
        fill();
        assert_eq!(Folder::restart(&path).unwrap(), folder);
        assert_eq!((list(&path).unwrap(), list(&folder.states()).unwrap()), (vec![folder.states()], vec![]));
        for foreign in [path.join("notes.txt"), folder.state(5), folder.checkpoint()] {
            fill();
            fs::write(&foreign, b"x").unwrap();
            assert!(matches!(Folder::restart(&path), Err(RecordError::NotEmpty { .. })), "{foreign:?}");
            assert!(folder.scene().exists() && folder.steps().exists());
            fs::remove_file(&foreign).unwrap();
        }
        fill();
        let busy = fs::File::open(folder.steps()).unwrap();
        busy.lock().unwrap();
        assert!(matches!(Folder::restart(&path), Err(RecordError::InUse { .. })));
    }

    #[test]
    fn rewinding_removes_later_states_and_leftovers_only() {
        let parent = tempfile::tempdir().unwrap();
        let folder = Folder::create(parent.path()).unwrap();
        for step in [0, 5, 10] {
            durable::write(&folder.state(step), b"x").unwrap();
        }
        fs::write(folder.states().join(".relcp-abc.part"), b"half").unwrap();
        fs::write(folder.states().join("mine.txt"), b"note").unwrap();
        folder.rewind(5).unwrap();
        let mut left: Vec<String> =
            fs::read_dir(folder.states()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        left.sort();
        assert_eq!(left, ["mine.txt", "state_0000000000.npz", "state_0000000005.npz"]);
    }
}
