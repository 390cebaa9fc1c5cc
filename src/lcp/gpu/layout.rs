//! Where things lie on the device: the fixed vectors, the numbers, and what a dispatch is told.

use super::number::RING;
use crate::lcp::SolverKind;

/// Sums that one stage brings together at most.
pub(super) const REDUCTIONS: u32 = 8;

/// Constants there is room for.
pub(super) const CONSTANTS: u32 = 32;

/// Residuals that one batch may note.
pub(super) const LOOKS: u32 = 32;

/// Where the constants begin among the numbers.
pub(super) const FIRST_CONSTANT: u32 = RING;

/// Which look ended the batch, counted from one; zero where none did. The looks follow it.
pub(super) const HALT: u32 = FIRST_CONSTANT + CONSTANTS;

/// All numbers.
pub(super) const NUMBERS: u32 = HALT + 1 + LOOKS;

/// Words of the grids of indirect dispatches: workgroups for rows and pairs, for bodies.
pub(super) const GRID_WORDS: usize = 6;

/// Vectors and numbers that one stage can be told.
pub(super) const MOST_VECTORS: usize = 32;
pub(super) const MOST_NUMBERS: usize = 16;

/// The vectors that every solve has, and those of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slots {
    pub q: u32,
    pub diagonal: u32,
    /// `1 / diagonal`, zero for zero rows.
    pub inverse: u32,
    /// The iterate.
    pub x: u32,
    /// The majorant and its inverse.
    pub majorant: Option<[u32; 2]>,
    /// What pairs of two rows need.
    pub coupling: Option<u32>,
    /// The first vector for others.
    pub free: u32,
}

impl Slots {
    pub fn of(kind: SolverKind) -> Self {
        let mut slots = Slots { q: 0, diagonal: 1, inverse: 2, x: 3, majorant: None, coupling: None, free: 4 };
        match kind {
            SolverKind::ProjectedJacobi => (slots.majorant, slots.free) = (Some([4, 5]), 6),
            SolverKind::Auto | SolverKind::PairBlockCg => (slots.coupling, slots.free) = (Some(4), 5),
            _ => {}
        }
        slots
    }
}

/// The parameters of a dispatch, as in `shaders/lcp/parameters.wgsl`.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Parameters {
    pub rows: u32,
    pub pairs: u32,
    pub bodies: u32,
    pub stride: u32,
    pub x: u32,
    pub add_q: u32,
    pub reduction: u32,
    pub reductions: u32,
    pub kinds: u32,
    pub groups: u32,
    pub first: u32,
    pub last: u32,
    pub unused: [u32; 4],
    pub vectors: [u32; MOST_VECTORS],
    pub numbers: [u32; MOST_NUMBERS],
}
