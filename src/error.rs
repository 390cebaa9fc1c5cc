//! The one error that every call of the library converts into.

use crate::gpu::GpuError;
use crate::scene::SceneError;
use crate::shape::{ConvexError, ProxyError, ShapeError};
use crate::simulation::ChangeError;
use crate::step::Fault;
#[cfg(feature = "files")]
use crate::{batch, export, measure, record, render, run};
use std::io;

/// Any error of this library: `?` converts each of them, so a program needs no other type.
///
/// [`source`](std::error::Error::source) is that of the error inside: its message is this one's.
///
/// ```
/// fn main() -> Result<(), relcp::Error> {
///     let mut scene = relcp::Scene::new("none", relcp::scene::Time::new(0.1, 1.0)); // without bodies
///     relcp::Shape::Sphere { radius: 1.0 }.validate()?;
///     scene.time.dt = -1.0;
///     let error = relcp::Simulation::new(scene).err().ok_or(std::io::Error::other("started"))?;
///     assert!(matches!(error, relcp::Error::Scene(_)));
///     Ok(())
/// }
/// ```
#[derive(Debug, thiserror::Error)]
#[cfg_attr(feature = "files", derive(miette::Diagnostic))]
#[non_exhaustive]
pub enum Error {
    /// A scene was refused.
    #[error(transparent)]
    #[cfg_attr(feature = "files", diagnostic(transparent))]
    Scene(#[from] SceneError),
    /// A simulation could not be started, or a step could not be taken.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// A change of a simulation's state was refused.
    #[error(transparent)]
    Change(#[from] ChangeError),
    /// A shape has a size out of range.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A shape has no multi-sphere proxy with this number of spheres.
    #[error(transparent)]
    Proxy(#[from] ProxyError),
    /// A support function is not that of a strictly convex body.
    #[error(transparent)]
    Convex(#[from] ConvexError),
    /// A device could not be opened, or failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The system refused to read or write.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The bytes are not those of a state.
    #[cfg(feature = "files")]
    #[error(transparent)]
    State(#[from] record::StateError),
    /// A run's file could not be read or written.
    #[cfg(feature = "files")]
    #[error(transparent)]
    #[cfg_attr(feature = "files", diagnostic(transparent))]
    Record(#[from] record::RecordError),
    /// Recorded states could not be found or read.
    #[cfg(feature = "files")]
    #[error(transparent)]
    #[cfg_attr(feature = "files", diagnostic(transparent))]
    States(#[from] record::StatesError),
    /// The bytes are not those of an LCP.
    #[cfg(feature = "files")]
    #[error(transparent)]
    Lcp(#[from] record::LcpFileError),
    /// A run stopped.
    #[cfg(feature = "files")]
    #[error(transparent)]
    #[cfg_attr(feature = "files", diagnostic(transparent))]
    Run(#[from] run::RunError),
    /// A batch could not be run.
    #[cfg(feature = "files")]
    #[error(transparent)]
    #[cfg_attr(feature = "files", diagnostic(transparent))]
    Batch(#[from] batch::BatchError),
    /// A member of a batch was not run to its end.
    #[cfg(feature = "files")]
    #[error(transparent)]
    Member(#[from] batch::MemberError),
    /// States could not be measured.
    #[cfg(feature = "files")]
    #[error(transparent)]
    #[cfg_attr(feature = "files", diagnostic(transparent))]
    Measure(#[from] measure::MeasureError),
    /// States could not be exported.
    #[cfg(feature = "files")]
    #[error(transparent)]
    #[cfg_attr(feature = "files", diagnostic(transparent))]
    Export(#[from] export::ExportError),
    /// Pictures could not be made.
    #[cfg(feature = "files")]
    #[error(transparent)]
    #[cfg_attr(feature = "files", diagnostic(transparent))]
    Render(#[from] render::RenderError),
}
