//! The layout of vectors, scalars and parameters on the device.

use super::number::RING;
use crate::gpu::{Precision, arguments};
use crate::lcp::SolverKind;

/// The largest number of sums that one stage computes.
pub(super) const REDUCTIONS: u32 = 8;

/// The largest number of rows of a pair whose small problem is solved exactly.
pub(super) const MOST_EXACT: u32 = 8;

/// The largest number of workgroups of a stage; with more rows, invocations process several rows. Each workgroup
/// reduces the partial sums of all, so a very large number costs more than it gains. On lavapipe 2 to 64 cost the same
/// within the noise at 2,900 rows; others were not measured on hardware.
pub(super) const MOST_GROUPS: u64 = 512;

/// The largest number of constants of a tape, plus one.
pub(super) const CONSTANTS: u32 = 32;

/// The largest number of recorded residuals that were not read yet: they are stored in a ring.
pub(super) const LOOKS: u32 = 128;

/// The offset of the first constant among the scalars.
pub(super) const FIRST_CONSTANT: u32 = RING;

/// The offset of the tolerance of a problem with friction, which is no constant of a kernel. It is that of the last
/// constant, which no tape uses.
pub(super) const TOLERANCE: u32 = FIRST_CONSTANT + CONSTANTS - 1;

/// The offset of the number of the check that ended the batch, counted from one over the solve; zero until a check ends
/// it. The residuals of the checks follow it.
pub(super) const HALT: u32 = FIRST_CONSTANT + CONSTANTS;

/// The number of scalars on the device.
pub(super) const NUMBERS: u32 = HALT + 1 + LOOKS;

/// Words of the grids of indirect dispatches: three for rows and pairs, three for bodies.
pub(super) const GRID_WORDS: usize = 6;

/// The largest number of vectors and scalars that one stage uses: a dispatch passes their offsets.
pub(super) const MOST_VECTORS: usize = 32;
pub(super) const MOST_NUMBERS: usize = 32;

/// The offsets of the vectors that every solve has, and of those that only some solvers have.
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
    /// The coupling of the two rows of a pair.
    pub coupling: Option<u32>,
    /// The rounding error of the iterate.
    pub low: Option<u32>,
    /// Whether problems are divided into clusters.
    pub clusters: bool,
    /// Vectors of contacts with friction, whose elements are four numbers.
    pub friction: Option<FrictionSlots>,
    /// The first offset that a method may use.
    pub free: u32,
}

/// The offsets of further vectors of contacts with friction. `inverse` has each contact's coefficient, the most part of
/// a change of its correction that is made, the scale of its block, and whether it is live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrictionSlots {
    pub compliance: u32,
    /// The corrections, with what they follow by.
    pub correction: u32,
    /// Changes of the contacts of a pair.
    pub scratch: u32,
}

/// The properties on which the sources depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Variant {
    pub precision: Precision,
    pub planar: bool,
    pub slots: Slots,
    /// Invocations of the workgroup that solves a small problem.
    pub small_workgroup: u32,
}

/// The offsets of two of them, the same for all solvers.
pub(super) const DIAGONAL: u32 = 1;
pub(super) const X: u32 = 3;

impl Slots {
    pub fn of(kind: SolverKind, precision: Precision) -> Self {
        let mut slots = Slots {
            q: 0,
            diagonal: DIAGONAL,
            inverse: 2,
            x: X,
            majorant: None,
            coupling: None,
            low: None,
            clusters: kind == SolverKind::ClusterCg,
            friction: None,
            free: 4,
        };
        match kind {
            SolverKind::ProjectedJacobi => (slots.majorant, slots.free) = (Some([4, 5]), 6),
            SolverKind::Auto | SolverKind::PairBlockCg | SolverKind::ClusterCg => {
                (slots.coupling, slots.free) = (Some(4), 5);
                if precision == Precision::F32 {
                    (slots.low, slots.free) = (Some(5), 6);
                }
            }
            SolverKind::Apgd
            | SolverKind::Bbpgd
            | SolverKind::ProjectedGaussSeidel
            | SolverKind::Dense
            | SolverKind::InteriorPoint => {}
        }
        slots
    }

    /// Those of contacts with friction.
    pub fn of_friction() -> Self {
        Slots {
            q: 0,
            diagonal: DIAGONAL,
            inverse: 2,
            x: X,
            majorant: None,
            coupling: None,
            low: None,
            clusters: false,
            friction: Some(FrictionSlots { compliance: 4, correction: 5, scratch: 6 }),
            free: 7,
        }
    }

    /// Whether the small problems of pairs need data of their own.
    pub fn has_blocks(&self) -> bool {
        self.coupling.is_some() || self.friction.is_some()
    }
}

impl Variant {
    /// Numbers of an element of a vector.
    pub fn element(&self) -> usize {
        if self.slots.friction.is_some() { 4 } else { 1 }
    }
}

/// Vectors of four numbers of a contact's block, before its rows of `J`.
pub(super) const BLOCK_WORDS: u32 = 6;

/// Rows of a contact with friction.
pub(super) const fn rows_of_contact(planar: bool) -> u32 {
    if planar { 2 } else { 3 }
}

/// Vectors of four numbers of a contact in `units`.
pub(super) const fn unit_words(planar: bool) -> u32 {
    BLOCK_WORDS + 2 * rows_of_contact(planar) * if planar { 1 } else { 2 }
}

arguments! {
    /// The parameters of a dispatch, as in `shaders/lcp/parameters.wgsl`.
    #[derive(Clone, Copy, Debug, Default)]
    pub(super) struct Parameters {
        rows: u32, pairs: u32, bodies: u32, stride: u32, groups: u32, looks: u32, base: u32, sums_from: u32,
        sums_into: u32, first: u32, last: u32, zero: u32,
        /// Offsets of vectors, four per word.
        vectors: [u32; MOST_VECTORS / 4],
        /// Offsets of scalars, two per word.
        numbers: [u32; MOST_NUMBERS / 2],
    }
}

impl Parameters {
    /// Sets the offsets of a stage's vectors and scalars.
    pub fn pass(&mut self, vectors: &[u32], numbers: &[u32]) {
        for (nth, place) in vectors.iter().enumerate() {
            self.vectors[nth / 4] |= place << (8 * (nth % 4));
        }
        for (nth, place) in numbers.iter().enumerate() {
            self.numbers[nth / 2] |= place << (16 * (nth % 2));
        }
    }
}
