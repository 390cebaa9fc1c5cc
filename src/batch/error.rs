//! Why a batch, or a member of one, could not be run.

use crate::gpu::GpuError;
use crate::record::RecordError;
use crate::run::RunError;
use crate::scene::SceneError;
use crate::step::Fault;
use miette::Diagnostic;
use thiserror::Error;

/// Why a batch failed before any member ran, or why its table could not be written.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum BatchError {
    /// The sweep, its scene, or a member's scene is refused.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A folder is refused, or a file could not be read or written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    /// The thread pool cannot be created.
    #[error("cannot create the thread pool: {0}")]
    Threads(String),
}

/// Why a member failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MemberError {
    /// Its bodies could not be placed.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Its simulation could not be started.
    #[error(transparent)]
    Start(Fault),
    /// The device failed or does not support the scene.
    #[error(transparent)]
    Device(#[from] GpuError),
    /// A step or a file failed.
    #[error(transparent)]
    Run(#[from] RunError),
}
