//! Why the pictures of a run could not be made.

use crate::gpu::GpuError;
use crate::record::{RecordError, StatesError};
use miette::Diagnostic;
use std::path::PathBuf;
use thiserror::Error;

/// Why the pictures of a run could not be made. Except for [`RenderError::Record`], [`RenderError::Encoder`] and
/// [`RenderError::Stopped`], nothing was written.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum RenderError {
    /// A state could not be found or read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    States(StatesError),
    /// The folder does not belong to a run.
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
    /// The device that casts the rays failed.
    #[error(transparent)]
    Device(#[from] GpuError),
    /// A state does not have the colour quantity.
    #[error("{origin}: no colours by {colour}: {why}")]
    Missing {
        /// The state.
        origin: String,
        /// The colour quantity.
        colour: &'static str,
        /// What is missing.
        why: String,
        /// The remedy.
        #[help]
        help: &'static str,
    },
    /// A range was given for colours without a scale.
    #[error("a range needs a numeric quantity; {colour} has no scale")]
    #[diagnostic(help("omit the range, or choose other colours"))]
    NoScale {
        /// The colour quantity.
        colour: &'static str,
    },
    /// Vector pictures have no light, no shadows and no hidden surfaces.
    #[error("vector pictures support planar runs seen from the top; this run is seen {side}")]
    #[diagnostic(help("choose png"))]
    NoVectors {
        /// The camera position, in words.
        side: &'static str,
    },
    /// No state is in the interval.
    #[error("none of the {states} states is {interval}; they are from time {first} to {last}")]
    #[diagnostic(help("choose another interval, or all states"))]
    Nothing {
        /// The number of states.
        states: usize,
        /// The interval, in words.
        interval: String,
        /// Time of the first state.
        first: f64,
        /// Time of the last state.
        last: f64,
    },
    /// Pictures would be mixed with other files, or replace them.
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
    #[diagnostic(help("the pictures are complete"))]
    Encoder {
        /// The movie.
        path: PathBuf,
        /// The end of its output.
        what: String,
    },
    /// The caller requested a stop.
    #[error("stopped after {done} of {all}")]
    #[diagnostic(help("draw again to start over and replace the files"))]
    Stopped {
        /// The number of pictures or states done.
        done: usize,
        /// The number of all.
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
