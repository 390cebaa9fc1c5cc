//! The candidate pairs, the list of pairs of each body, and the stored values of each pair.

use super::Setup;
use crate::gpu::{Buffer, Gpu, GpuError, arrays};

/// The pairs, the list of pairs of each body, and the stored values of each pair.
pub(super) struct Lists {
    /// The number of pairs of bodies, plus places of bodies at surfaces.
    pub pairs_count: u64,
    pub body_pairs: u64,
    pub pairs: Buffer,
    pub adjacency_start: Buffer,
    pub adjacency: Buffer,
    /// Three vectors per pair, see `shaders/separation/narrow.wgsl`.
    pub contacts: Buffer,
    /// For rows by branches: the multipliers of each pair's branches at the end of the last step.
    pub remembered: Buffer,
    pub bodies: u64,
}

arrays! { Lists {
    pairs, adjacency_start, start: adjacency_start, adjacency, contacts, remembered; pairs: pairs_count
} }

impl Lists {
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Self, GpuError> {
        Ok(Lists {
            pairs_count: 0,
            body_pairs: 0,
            pairs: Buffer::new(gpu, "pairs", 8, 0)?,
            adjacency_start: Buffer::new(gpu, "adjacency starts", 4, 1)?,
            adjacency: Buffer::new(gpu, "adjacency", 4, 0)?,
            contacts: Buffer::new(gpu, "contacts", 12 * setup.precision.bytes(), 0)?,
            remembered: remembered(gpu, setup)?,
            bodies: 0,
        })
    }
}

/// A buffer for the stored multipliers of each pair's branches.
pub(super) fn remembered(gpu: &Gpu, setup: &Setup) -> Result<Buffer, GpuError> {
    Buffer::new(gpu, "multipliers of branches", setup.branches.max(1) as usize * setup.precision.bytes(), 0)
}
