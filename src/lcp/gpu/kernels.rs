//! The kernels of one solver: their sources, put together for a number type, a dimension and a kind of solver.

use super::layout::{CONSTANTS, GRID_WORDS, HALT, NUMBERS, REDUCTIONS, Slots};
use crate::gpu::{Gpu, GpuError, Kernel, Precision, Source, WORKGROUP, fragment};

/// Invocations of the one workgroup that brings partial sums together.
const FINISH_WORKGROUP: u32 = 256;

/// Invocations of the one workgroup that solves a small problem.
pub(super) const SMALL_WORKGROUP: u32 = 64;

/// Relative addition to the diagonal of a pair's block, as on the CPU, or so many roundings where that is more: the entries of a block
/// are sums of products, each with its rounding.
const REGULARIZATION: f64 = 1e-6;
const ROUNDINGS: f64 = 32.0;

/// Sweeps over the rows of a pair that has too many for the exact method.
const SWEEPS: u32 = 16;

/// What the sources depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Variant {
    pub precision: Precision,
    pub planar: bool,
    pub slots: Slots,
}

pub(super) struct Kernels {
    pub prepare_rows: Kernel,
    pub prepare_entries: Kernel,
    pub rows: Kernel,
    pub product: Kernel,
    pub bodies: Kernel,
    pub finish: Kernel,
    pub small: Kernel,
    /// For solvers with blocks of pairs: what they want to know of pairs, and the steps.
    pub pairs: Option<[Kernel; 2]>,
}

impl Kernels {
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self, GpuError> {
        let kernel = |source: Source| Kernel::new(gpu, &source);
        Ok(Kernels {
            prepare_rows: kernel(variant.prepare_rows())?,
            prepare_entries: kernel(variant.prepare_entries())?,
            rows: kernel(variant.rows(false))?,
            product: kernel(variant.rows(true))?,
            bodies: kernel(variant.bodies())?,
            finish: kernel(variant.finish())?,
            small: kernel(variant.small())?,
            pairs: match variant.slots.coupling {
                Some(_) => Some([kernel(variant.prepare_pairs())?, kernel(variant.pairs())?]),
                None => None,
            },
        })
    }
}

impl Variant {
    fn source(&self, name: &str, workgroup: u32) -> Source {
        let slots = &self.slots;
        let shift = (ROUNDINGS * self.precision.epsilon()).max(REGULARIZATION);
        Source::with_workgroup(format!("lcp-{name}"), self.precision, workgroup)
            .integer("WIDTH", if self.planar { 1 } else { 2 })
            .integer("Q", slots.q)
            .integer("DIAGONAL", slots.diagonal)
            .integer("INVERSE", slots.inverse)
            .integer("X", slots.x)
            .integer("NONE", u32::MAX)
            .integer("MAJORANT", slots.majorant.map_or(u32::MAX, |[majorant, _]| majorant))
            .integer("COUPLING", slots.coupling.unwrap_or(u32::MAX))
            .integer("REDUCTIONS", REDUCTIONS)
            .integer("NUMBERS", NUMBERS)
            .integer("HALT", HALT)
            .integer("GRID_WORDS", GRID_WORDS as u32)
            .integer("SWEEPS", SWEEPS)
            .real("REGULARIZATION", shift)
            .real("SHIFT", 1.0 + shift)
            .real("SHIFT_OF_DETERMINANT", shift * (2.0 + shift))
            .real("LEAST_PIVOT", 0.1 * shift)
            .include(fragment!("lcp/parameters.wgsl"))
    }

    fn reducing(&self, name: &str, workgroup: u32) -> Source {
        self.source(name, workgroup).include(fragment!("lcp/reduce.wgsl")).include(fragment!("lcp/instructions.wgsl"))
    }

    pub fn rows(&self, product: bool) -> Source {
        let source = self.reducing(if product { "product" } else { "rows" }, WORKGROUP);
        let source = source.include(fragment!("lcp/leave_sums.wgsl")).include(fragment!("lcp/main_rows.wgsl"));
        match product {
            true => source.include(fragment!("lcp/rows_product.wgsl")).include(fragment!("lcp/jacobian.wgsl")),
            false => source.include(fragment!("lcp/rows_plain.wgsl")),
        }
    }

    pub fn pairs(&self) -> Source {
        self.reducing("pairs", WORKGROUP)
            .include(fragment!("lcp/leave_sums.wgsl"))
            .include(fragment!("lcp/main_pairs.wgsl"))
            .include(fragment!("lcp/pair_block.wgsl"))
    }

    pub fn bodies(&self) -> Source {
        self.source("bodies", WORKGROUP).include(fragment!("lcp/main_bodies.wgsl"))
    }

    pub fn finish(&self) -> Source {
        self.source("finish", FINISH_WORKGROUP)
            .include(fragment!("lcp/reduce.wgsl"))
            .include(fragment!("lcp/numbers.wgsl"))
            .include(fragment!("lcp/main_finish.wgsl"))
    }

    pub fn small(&self) -> Source {
        let source = self
            .reducing("small", SMALL_WORKGROUP)
            .include(fragment!("lcp/numbers.wgsl"))
            .include(fragment!("lcp/jacobian.wgsl"))
            .include(fragment!("lcp/main_small.wgsl"));
        match self.slots.coupling {
            Some(_) => source.include(fragment!("lcp/pair_block.wgsl")).include(fragment!("lcp/small_pairs.wgsl")),
            None => source.text("fn run_pairs(kind: u32, place: u32, local: u32) {}\n"),
        }
    }

    pub fn prepare_rows(&self) -> Source {
        self.source("prepare-rows", WORKGROUP).include(fragment!("lcp/prepare_rows.wgsl"))
    }

    pub fn prepare_entries(&self) -> Source {
        self.source("prepare-entries", WORKGROUP).include(fragment!("lcp/prepare_entries.wgsl"))
    }

    pub fn prepare_pairs(&self) -> Source {
        self.source("prepare-pairs", WORKGROUP)
            .include(fragment!("lcp/prepare_pairs.wgsl"))
            .include(fragment!("lcp/pair_block.wgsl"))
    }
}

const _: () = assert!(CONSTANTS >= 32);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::validate;
    use crate::scene::SolverKind;

    #[test]
    fn all_sources_are_valid() {
        for precision in [Precision::F32, Precision::F64] {
            for planar in [true, false] {
                for kind in [SolverKind::Auto, SolverKind::Bbpgd, SolverKind::ProjectedJacobi] {
                    let v = Variant { precision, planar, slots: Slots::of(kind) };
                    let common = [v.rows(false), v.rows(true), v.bodies(), v.finish(), v.small()];
                    let pairs = [v.pairs(), v.prepare_pairs()].into_iter().filter(|_| v.slots.coupling.is_some());
                    for source in common.into_iter().chain([v.prepare_rows(), v.prepare_entries()]).chain(pairs) {
                        validate(&source).unwrap_or_else(|e| panic!("{} {precision:?}: {e}", source.name()));
                    }
                }
            }
        }
    }
}
