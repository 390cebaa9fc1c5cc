//! Errors of a run's files.

use crate::scene::SceneError;
use miette::Diagnostic;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why the bytes of a state were refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum StateError {
    /// The bytes have another format.
    #[error("not a state file")]
    NotAState,
    /// The end is missing.
    #[error("the file is truncated")]
    Truncated,
    /// Some bytes were changed.
    #[error("{place} is damaged: {what}")]
    Damaged {
        /// The part.
        place: String,
        /// The problem.
        what: String,
    },
    /// A later program wrote it.
    #[error("it has version {found} of the format; this program reads versions up to {known}")]
    Newer {
        /// The file's version.
        found: u64,
        /// The newest that can be read.
        known: u64,
    },
    /// A body has a custom shape.
    #[error("body {body} has a custom shape, which files cannot store")]
    Custom {
        /// The first body concerned.
        body: usize,
    },
    /// The state cannot be encoded.
    #[error("the state cannot be packed: {0}")]
    Unwritable(String),
}

impl StateError {
    pub(super) fn damaged(place: impl Display, what: impl Display) -> Self {
        StateError::Damaged { place: place.to_string(), what: what.to_string() }
    }

    pub(super) fn row(name: &'static str, row: usize) -> Self {
        StateError::damaged(name, format!("row {row} cannot be"))
    }
}

/// Why the bytes of an LCP were refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LcpFileError {
    /// The bytes have another format.
    #[error("this is not an LCP (.npz): {0}")]
    NotAnLcp(String),
    /// Some bytes are missing, changed, or not valid.
    #[error("{place} is damaged: {what}")]
    Damaged {
        /// The part.
        place: String,
        /// The problem.
        what: String,
    },
    /// A later program wrote it.
    #[error("it has version {found} of the format; this program reads versions up to {known}")]
    Newer {
        /// The file's version.
        found: u64,
        /// The newest that can be read.
        known: u64,
    },
    /// The LCP cannot be encoded.
    #[error("the LCP cannot be packed: {0}")]
    Unwritable(String),
}

/// Why a run's files could not be read or written.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum RecordError {
    /// The system reported an error.
    #[error("{}: could not {action}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The action.
        action: &'static str,
        /// The system's error.
        #[source]
        source: io::Error,
    },
    /// A state file cannot be used.
    #[error("{}: {fault}", path.display())]
    State {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: StateError,
    },
    /// A file with an LCP cannot be used.
    #[error("{}: {fault}", path.display())]
    Lcp {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: LcpFileError,
    },
    /// A file of a run was changed.
    #[error("{}: {what}", path.display())]
    Mangled {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A new run would mix its files with others.
    #[error("{}: the folder is not empty", path.display())]
    #[diagnostic(help("name another folder, or resume the run that is in it"))]
    NotEmpty {
        /// The folder.
        path: PathBuf,
    },
    /// There is nothing to resume.
    #[error("{}: nothing to resume: no checkpoint found", path.display())]
    #[diagnostic(help("name the folder of an earlier run, or start a new one"))]
    NoCheckpoint {
        /// The folder.
        path: PathBuf,
    },
    /// The folder belongs to a different scene.
    #[error("{}: this folder belongs to a different scene (differs in {})", path.display(), keys.join(", "))]
    #[diagnostic(help("use the scene and the overrides of the run"))]
    OtherScene {
        /// The folder.
        path: PathBuf,
        /// The first keys that differ.
        keys: Vec<String>,
    },
    /// The folder's run cannot continue to a later end.
    #[error("{}: cannot continue the run: {why}", path.display())]
    NoLaterEnd {
        /// The folder.
        path: PathBuf,
        /// The reason and the remedy.
        why: String,
    },
    /// No run can begin with a state of this one.
    #[error("{}: no run can begin from it: {why}", path.display())]
    NoBranch {
        /// The folder of the other run.
        path: PathBuf,
        /// The reason and the remedy.
        why: String,
    },
    /// Another process is writing into the folder.
    #[error("{}: another run is writing into this folder", path.display())]
    #[diagnostic(help("wait for it, stop it, or name another folder"))]
    InUse {
        /// The folder.
        path: PathBuf,
    },
}

impl RecordError {
    /// Whether a file of a run is damaged.
    pub fn is_damage(&self) -> bool {
        matches!(self, RecordError::State { .. } | RecordError::Mangled { .. })
    }

    /// An error of the system at a file during an action.
    pub fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> RecordError {
        let path = path.to_owned();
        move |source| RecordError::Io { path, action, source }
    }

    pub(crate) fn state(path: &Path) -> impl FnOnce(StateError) -> RecordError {
        let path = path.to_owned();
        move |fault| RecordError::State { path, fault }
    }
}

/// Why states could not be found or read.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum StatesError {
    /// A file could not be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    /// A scene was refused.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The folder does not belong to a run.
    #[error("{}: there is no state", path.display())]
    #[diagnostic(help(
        "name a run's folder (it has states/, checkpoint.npz or final.json), a state (.npz), a scene file or a built-in scene"
    ))]
    NoState {
        /// The folder.
        path: PathBuf,
    },
    /// A shape that no file format supports.
    #[error("{origin}: body {body} has a custom shape, which files cannot store")]
    Custom {
        /// The state.
        origin: String,
        /// The first body concerned, by its row.
        body: usize,
    },
}
