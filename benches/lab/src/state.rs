//! Large states that consist of copies of a stored one.

use glam::DVec3;
use relcp::Error;
use relcp::bodies::{Bodies, Lineage};
use relcp::gpu::GpuError;
use relcp::record::{LcpFileError, RecordError, StateError, decode};
use relcp::run::RunError;
use relcp::scene::SceneError;
use relcp::step::Fault;

/// The reason why a study failed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StudyError {
    /// A stored state could not be read.
    #[error(transparent)]
    State(#[from] StateError),
    /// A run could not be recorded.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    /// A run stopped.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// A scene could not be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A step could not be taken.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// The device reported an error.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A stored LCP could not be read.
    #[error(transparent)]
    Lcp(#[from] LcpFileError),
    /// A stored reference solution is damaged, or belongs to another scene.
    #[error("reference solution of {0}")]
    Reference(String),
    /// A plot could not be drawn.
    #[error("a plot could not be drawn: {0}")]
    Plot(String),
    /// Threads could not be started.
    #[error("threads: {0}")]
    Threads(String),
    /// A table could not be made.
    #[error("a table could not be made: {0}")]
    Table(String),
    /// A file of results is damaged.
    #[error("results of a study are damaged: {0}")]
    Damaged(String),
    /// A file of results belongs to another device or version.
    #[error("{0}")]
    Elsewhere(String),
    /// Something else failed.
    #[error(transparent)]
    Other(Error),
}

impl From<Error> for StudyError {
    fn from(error: Error) -> Self {
        match error {
            Error::State(error) => StudyError::State(error),
            Error::Record(error) => StudyError::Record(error),
            Error::Run(error) => StudyError::Run(error),
            Error::Scene(error) => StudyError::Scene(error),
            Error::Fault(error) => StudyError::Fault(error),
            Error::Gpu(error) => StudyError::Gpu(error),
            Error::Lcp(error) => StudyError::Lcp(error),
            other => StudyError::Other(other),
        }
    }
}

/// Places copies of a stored state side by side, `count` bodies in total: in a square if the state lies in the plane z
/// = 0, otherwise in a cube. The copies are a body's length apart, so they have no contact with each other.
pub fn tiled(stored: &[u8], count: usize) -> Result<Bodies, StudyError> {
    let (_, state) = decode(stored)?;
    let tile = state.bodies;
    let planar = tile.position.iter().all(|x| x.z == 0.0);
    let reach = |axis: fn(&DVec3) -> f64| tile.position.iter().map(|x| axis(x).abs()).fold(0.0, f64::max);
    let longest = tile.shape.iter().map(|s| s.major_axis()).fold(0.0, f64::max);
    let pitch = 2.0 * (reach(|x| x.x).max(reach(|x| x.y)).max(reach(|x| x.z)) + longest);
    let tiles = count.div_ceil(tile.len().max(1));
    let side = if planar { (tiles as f64).sqrt() } else { (tiles as f64).cbrt() }.ceil().max(1.0) as usize;
    let mut bodies = Bodies::default();
    for t in 0..tiles {
        let place = [t % side, t / side % side, t / side / side].map(|k| k as f64 - 0.5 * (side as f64 - 1.0));
        let mut offset = pitch * DVec3::from_array(place);
        if planar {
            offset.z = 0.0;
        }
        for i in 0..tile.len().min(count - bodies.len()) {
            let mut placed = tile.placed(i);
            placed.position += offset;
            let index = bodies.push(placed, tile.group[i]);
            bodies.lineage[index] = Lineage { id: index as u64, parent: None, ..tile.lineage[i] };
        }
    }
    Ok(bodies)
}
