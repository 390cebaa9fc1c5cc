//! The buffers of a machine, by their names in kernels.

use super::layout::{GRID_WORDS, MOST_EXACT, MOST_GROUPS, NUMBERS, REDUCTIONS, Variant, rows_of_contact, unit_words};
use super::problem::DeviceProblem;
use super::straight::ELEMENT_WORDS;
use crate::gpu::{Buffer, Gpu, GpuError, Recorder, arrays};

/// Partial sums of one stage, of the next one, and of the confirmation of a check.
const PARTS: u64 = 3;

/// The working memory of kernels, in addition to the problem.
pub(super) struct Memory {
    pub program: Buffer,
    /// The offsets of the vectors and scalars of repeated elements.
    pub rounds: Buffer,
    pub scalars: Buffer,
    pub vectors: Buffer,
    partial: Buffer,
    pub grid: Buffer,
    gathered: Buffer,
    /// The rounding error of the velocities.
    velocity_rest: Buffer,
    pub lists: Buffer,
    /// The blocks of pairs with more than two rows.
    entries: Buffer,
    /// The end of each row's pair, with a mark at its first row.
    span: Buffer,
    /// The tables of clusters, and the displacements from their local LCPs.
    pub clusters: Buffer,
    pub part_start: Buffer,
    pub displacement: Buffer,
    /// Of contacts with friction: the rows of tangents, the coefficients and compliances, the multipliers, and what
    /// their small problems need.
    pub tangents: Buffer,
    pub contacts: Buffer,
    pub gammas: Buffer,
    units: Buffer,
}

arrays! { Memory {
    program, rounds, scalars, vectors, partial, grid, gathered, velocity_rest, lists, entries, span, clusters,
    part_start, displacement, tangents, contacts, gammas, units,
} }

impl Memory {
    pub fn new(gpu: &Gpu, variant: &Variant) -> Result<Self, GpuError> {
        let real = variant.precision.bytes();
        let words = |label| Buffer::new(gpu, label, 4, 1);
        let reals = |label, width: usize| Buffer::new(gpu, label, width * real, 1);
        Ok(Memory {
            program: Buffer::new(gpu, "lcp-program", 16, 1)?,
            rounds: Buffer::new(gpu, "lcp-rounds", 4 * ELEMENT_WORDS, 1)?,
            scalars: Buffer::new(gpu, "lcp-numbers", real, u64::from(NUMBERS))?,
            vectors: reals("lcp-vectors", variant.element())?,
            partial: Buffer::new(gpu, "lcp-partial", real, PARTS * u64::from(REDUCTIONS) * MOST_GROUPS)?,
            grid: Buffer::new(gpu, "lcp-grid", 4, GRID_WORDS as u64)?,
            gathered: reals("lcp-gathered", 4)?,
            velocity_rest: reals("lcp-velocity-rest", 4)?,
            lists: words("lcp-lists")?,
            entries: reals("lcp-entries", 1)?,
            span: words("lcp-spans")?,
            clusters: words("lcp-clusters")?,
            part_start: words("lcp-part-starts")?,
            displacement: reals("lcp-displacements", 1)?,
            tangents: reals("lcp-tangents", 4)?,
            contacts: reals("lcp-contacts", 4)?,
            gammas: reals("lcp-gammas", 4)?,
            units: reals("lcp-units", 4)?,
        })
    }

    /// Reserves memory for a problem and this many vectors; `small` if one workgroup solves it.
    pub fn reserve(
        &mut self,
        record: &mut Recorder<'_>,
        variant: &Variant,
        problem: &DeviceProblem,
        (vectors, small): (u32, bool),
    ) -> Result<(), GpuError> {
        let (gpu, width) = (record.gpu(), if problem.planar { 1 } else { 2 });
        self.vectors.reserve_and_keep(gpu, record, u64::from(vectors) * problem.stride())?;
        if small {
            self.lists.reserve(gpu, 4 * problem.rows + problem.pairs + problem.bodies + 2)?;
        } else {
            self.gathered.reserve(gpu, 2 * problem.rows * width)?;
        }
        if variant.slots.friction.is_some() {
            self.gathered.reserve(gpu, 2 * problem.rows * width * u64::from(rows_of_contact(problem.planar)))?;
            self.units.reserve(gpu, problem.rows * u64::from(unit_words(problem.planar)))?;
        }
        if variant.slots.coupling.is_some() {
            self.entries.reserve(gpu, problem.rows * u64::from(MOST_EXACT))?;
        }
        if variant.slots.has_blocks() {
            self.span.reserve(gpu, problem.rows)?;
        }
        if variant.slots.low.is_some() {
            self.velocity_rest.reserve(gpu, problem.bodies * width)?;
        }
        Ok(())
    }
}
