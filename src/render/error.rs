//! Why the pictures of a run could not be made.

use crate::gpu::GpuError;
use crate::record::{RecordError, StatesError};
use miette::Diagnostic;
use std::path::PathBuf;
use thiserror::Error;

/// Why the pictures of a run could not be made. But for [`RenderError::Record`], [`RenderError::Encoder`] and
/// [`RenderError::Stopped`] nothing was written.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum RenderError {
    /// A state could not be found or read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    States(StatesError),
    /// The folder is not that of a run.
    #[error("{}: no state to draw", path.display())]
    #[diagnostic(help(
        "name a run's folder (it has states/, checkpoint.npz or final.json), a state (.npz), a scene file or a built-in scene"
    ))]
    NoState {
        /// The folder.
        path: PathBuf,
    },
    /// A file could not be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    /// The device that was to cast the rays failed.
    #[error(transparent)]
    Device(#[from] GpuError),
    /// A state does not have the colour quantity.
    #[error("{origin}: no colours by {colour}: {why}")]
    Missing {
        /// The state.
        origin: String,
        /// The colour quantity.
        colour: &'static str,
        /// What is not there.
        why: String,
        /// What would be right.
        #[help]
        help: &'static str,
    },
    /// The ends of a scale were given for colours that are on none.
    #[error("a range needs a numeric quantity; {colour} has no scale")]
    #[diagnostic(help("leave the range out, or choose other colours"))]
    NoScale {
        /// The colour quantity.
        colour: &'static str,
    },
    /// Vectors have no light, no shadows and nothing hidden.
    #[error("vector pictures support planar runs seen from the top; this run is seen {side}")]
    #[diagnostic(help("choose png"))]
    NoVectors {
        /// From where, in words.
        side: &'static str,
    },
    /// No state is in the interval.
    #[error("none of the {states} states is {interval}; they are from time {first} to {last}")]
    #[diagnostic(help("choose another interval, or all states"))]
    Nothing {
        /// How many there are.
        states: usize,
        /// The interval, in words.
        interval: String,
        /// Time of the first state.
        first: f64,
        /// Time of the last state.
        last: f64,
    },
    /// Pictures would be mixed with others, or replace them.
    #[error("{}: the folder has numbered pictures that relcp did not draw", path.display())]
    #[diagnostic(help("name another folder"))]
    Foreign {
        /// Their folder.
        path: PathBuf,
    },
    /// There is no encoder for a video.
    #[error("cannot make a video: `ffmpeg` is not on the path")]
    #[diagnostic(help("install ffmpeg, or make an animated PNG, which needs none"))]
    NoEncoder,
    /// The encoder did not make the movie.
    #[error("{}: ffmpeg failed: {what}", path.display())]
    #[diagnostic(help("the pictures are there all the same"))]
    Encoder {
        /// The movie.
        path: PathBuf,
        /// What it said.
        what: String,
    },
    /// The caller requested a stop.
    #[error("stopped after {done} of {all}")]
    #[diagnostic(help("draw again to start over and replace the files"))]
    Stopped {
        /// How much was done.
        done: usize,
        /// Of how much.
        all: usize,
    },
}

impl From<StatesError> for RenderError {
    fn from(error: StatesError) -> Self {
        match error {
            StatesError::NoState { path } => RenderError::NoState { path },
            other => RenderError::States(other),
        }
    }
}
