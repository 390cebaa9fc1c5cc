//! Why a step could not be taken.

use super::{Unresolved, Wedge};
use crate::constraint::RowSourceError;
use crate::digits::few;
use crate::gpu::GpuError;

/// Why a step could not be taken. The simulation keeps its last accepted state.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// A number that is not finite turned up.
    #[error(
        "step {step}: the {what} of body {body} is not finite; its forces are too large for dt, or a plugged-in force is not finite"
    )]
    NotFinite {
        /// The step that was being taken.
        step: u64,
        /// Which quantity.
        what: &'static str,
        /// The first body concerned.
        body: usize,
    },
    /// A body reaches so far, or moves so far in the step, that it could meet another at two images.
    #[error(
        "step {step}: body {body} spans {} with the cutoff and its displacement in the step, over half of the period {}; use a smaller dt or a larger period", few(*.span), few(*.period)
    )]
    PeriodTooShort {
        /// The step that was being taken.
        step: u64,
        /// The first body concerned.
        body: usize,
        /// Its length, the cutoff and twice its way in the step, a length.
        span: f64,
        /// The shortest period.
        period: f64,
    },
    /// A body of a periodic scene has gone so far that its nearest images are not known to the overlap tolerance.
    #[error(
        "step {step}: body {body} is so far from the origin that 64-bit floats are coarser there than contact.overlap_tolerance; positions are not wrapped"
    )]
    TooFar {
        /// The step that was being taken.
        step: u64,
        /// The first body concerned.
        body: usize,
    },
    /// A body has gone so far that something has driven it away: a force that grows with the distance, or steps that
    /// are too long for the forces.
    #[error(
        "step {step}: body {body} is {} from where the scene starts, over a million of its thicknesses; its forces are \
         too large for time.dt, or drive it away", few(*.distance)
    )]
    RunAway {
        /// The step that was taken.
        step: u64,
        /// The first body concerned.
        body: usize,
        /// From the middle of the bodies at the start, a length.
        distance: f64,
    },
    /// A step that still misses a tolerance after it was cut into 64 pieces.
    #[error("{0}; {remedy}", remedy = .0.remedy())]
    Unresolved(Unresolved),
    /// A step that cannot be taken with the growth of its cells, and can without.
    #[error(
        "no room: {} ({bodies} in all); with growth, {unresolved}. growth.on_no_room = \"stall\" makes cells without room wait; {}",
        wedge.pressed(unresolved), unresolved.remedy_of_no_room()
    )]
    NoRoom {
        /// All cells.
        bodies: usize,
        /// Those that have no way out.
        wedge: Box<Wedge>,
        /// What the step would leave.
        unresolved: Box<Unresolved>,
    },
    /// The scene's solver needs more memory than its limit.
    #[error(
        "step {step}: solver interior_point needs more than 256 MiB for the factor of {rows} rows; use solver auto"
    )]
    TooLarge {
        /// The step that was being taken.
        step: u64,
        /// How many rows there are.
        rows: usize,
    },
    /// A body has no multi-sphere proxy with the scene's number of spheres.
    #[error("no multi-sphere proxy: {0}")]
    NoProxy(#[from] RowSourceError),
    /// A force that was added in code failed.
    #[error("step {step}: an added force failed: {what}")]
    Force {
        /// The step that was being taken.
        step: u64,
        /// Its message.
        what: String,
    },
    /// A change of the scene's keys failed.
    #[error("step {step}: a change of the scene failed: {what}")]
    Change {
        /// The steps taken before it.
        step: u64,
        /// The reason.
        what: String,
    },
    /// A rule of the simulation's [`Rules`](crate::simulation::Rules) failed, or set a value that is not allowed.
    #[error("step {step}: {what}")]
    Rules {
        /// The step that was being taken.
        step: u64,
        /// Which rule, and why.
        what: String,
    },
    /// The device failed, or does not support the scene.
    #[error(transparent)]
    Device(#[from] GpuError),
    /// The processes of a simulation cannot continue.
    #[error("the processes of this run cannot continue: {0}")]
    Processes(String),
}

impl Fault {
    /// Whether a smaller `dt` may help: after an overflow, or a displacement too long for the period.
    pub(super) fn may_pass_with_smaller_steps(&self) -> bool {
        matches!(self, Fault::NotFinite { .. } | Fault::PeriodTooShort { .. })
    }

    /// Whether the scene has no solution or leaves the range of numbers, rather than a program or a device that failed.
    pub fn is_of_scene(&self) -> bool {
        !matches!(self, Fault::Device(_) | Fault::Processes(_))
    }

    /// Its name in files and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Fault::NotFinite { .. } => "not_finite",
            Fault::PeriodTooShort { .. } => "period_too_short",
            Fault::TooFar { .. } => "too_far",
            Fault::RunAway { .. } => "run_away",
            Fault::Unresolved(unresolved) => unresolved.name(),
            Fault::NoRoom { .. } => "no_room",
            Fault::TooLarge { .. } => "too_large",
            Fault::NoProxy(_) => "no_proxy",
            Fault::Force { .. } => "force",
            Fault::Change { .. } => "change",
            Fault::Rules { .. } => "rules",
            Fault::Device(_) => "device",
            Fault::Processes(_) => "processes",
        }
    }
}
