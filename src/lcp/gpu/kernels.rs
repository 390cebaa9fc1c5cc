//! The kernels of one solver, assembled for a number type, a dimension and a kind of solver.

use super::layout::{GRID_WORDS, HALT, NUMBERS, REDUCTIONS, Slots};
use super::number::Operation;
use super::shape::Shape;
use super::tape::{Action, REDUCTION_KINDS};
use crate::gpu::{Gpu, GpuError, Kernel, Precision, Source, WORKGROUP, fragment};
use std::collections::HashMap;

/// Invocations of the workgroup that adds up partial sums.
const FINISH_WORKGROUP: u32 = 256;

/// Invocations of the workgroup that solves a small problem.
pub(super) const SMALL_WORKGROUP: u32 = 32;

/// Relative addition to the diagonal of a pair's block, as on the CPU; at least this many roundings, because the
/// entries of a block are sums of products, each with its rounding.
const REGULARIZATION: f64 = 1e-6;
const ROUNDINGS: f64 = 32.0;

/// The most rows of a pair whose small problem is solved exactly.
pub(super) const MOST_EXACT: u32 = 8;

/// What the sources depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Variant {
    pub precision: Precision,
    pub planar: bool,
    pub slots: Slots,
}

/// The kernels of a solver. Each is compiled when a problem first needs it: few scenes have both small and large
/// problems.
#[derive(Default)]
pub(super) struct Kernels {
    prepare_rows: Option<Kernel>,
    large: Option<Large>,
    small: Option<Kernel>,
    /// For solvers with blocks of pairs.
    prepare_pairs: Option<Kernel>,
    stages: HashMap<Shape, Kernel>,
}

/// Kernels that all large problems need.
pub(super) struct Large {
    pub prepare_entries: Kernel,
    pub bodies: Kernel,
    pub finish: Kernel,
}

impl Kernels {
    /// Compiles the kernels that every small problem needs, or every large one.
    pub fn make_common(&mut self, gpu: &Gpu, variant: Variant, small: bool) -> Result<(), GpuError> {
        let kernel = |source: Source| Kernel::new(gpu, &source);
        if self.prepare_rows.is_none() {
            self.prepare_rows = Some(kernel(variant.prepare_rows())?);
        }
        if self.prepare_pairs.is_none() && variant.slots.coupling.is_some() {
            self.prepare_pairs = Some(kernel(variant.prepare_pairs())?);
        }
        if self.small.is_none() && small {
            self.small = Some(kernel(variant.small())?);
        }
        if self.large.is_none() && !small {
            let prepare_entries = kernel(variant.prepare_entries())?;
            let (bodies, finish) = (kernel(variant.bodies())?, kernel(variant.finish())?);
            self.large = Some(Large { prepare_entries, bodies, finish });
        }
        Ok(())
    }

    pub fn prepare_rows(&self) -> Option<&Kernel> {
        self.prepare_rows.as_ref()
    }

    pub fn prepare_pairs(&self) -> Option<&Kernel> {
        self.prepare_pairs.as_ref()
    }

    pub fn small(&self) -> Option<&Kernel> {
        self.small.as_ref()
    }

    pub fn large(&self) -> Option<&Large> {
        self.large.as_ref()
    }

    /// Compiles the kernel of a stage, once.
    pub fn make(&mut self, gpu: &Gpu, variant: Variant, shape: &Shape) -> Result<(), GpuError> {
        if !self.stages.contains_key(shape) {
            self.stages.insert(shape.clone(), Kernel::new(gpu, &variant.stage(shape))?);
        }
        Ok(())
    }

    pub fn stage(&self, shape: &Shape) -> Option<&Kernel> {
        self.stages.get(shape)
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
            .integer("MOST_EXACT", MOST_EXACT)
            .real("REGULARIZATION", shift)
            .real("SHIFT", 1.0 + shift)
            .real("SHIFT_OF_DETERMINANT", shift * (2.0 + shift))
            .real("LEAST_PIVOT", 0.1 * shift)
            .constants("kinds of reductions", REDUCTION_KINDS)
            .constants("actions on rows", Action::ALL.map(|action| (action.constant(), action as u32)))
            .constants("operations on numbers", Operation::ALL.map(|what| (what.constant(), what as u32)))
            .include(fragment!("lcp/parameters.wgsl"))
    }

    fn reducing(&self, name: &str, workgroup: u32) -> Source {
        self.source(name, workgroup).include(fragment!("lcp/reduce.wgsl")).include(fragment!("lcp/instructions.wgsl"))
    }

    /// The kernel of a stage.
    pub fn stage(&self, shape: &Shape) -> Source {
        let name = match (shape.has_block(), shape.has_product()) {
            (true, _) => "pairs",
            (_, true) => "product",
            _ => "rows",
        };
        let source = self.reducing(name, WORKGROUP).include(fragment!("lcp/leave_sums.wgsl"));
        let text = shape.text(|x| source.literal(x));
        let source = match (shape.has_block(), shape.has_product()) {
            (true, _) => source
                .include(fragment!("lcp/main_pairs.wgsl"))
                .integer("ENTRIES_BINDING", 5)
                .include(fragment!("lcp/pair_block.wgsl")),
            (_, true) => source
                .include(fragment!("lcp/main_rows.wgsl"))
                .include(fragment!("lcp/rows_product.wgsl"))
                .include(fragment!("lcp/jacobian.wgsl")),
            _ => source.include(fragment!("lcp/main_rows.wgsl")),
        };
        source.text(&text)
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
            .include(fragment!("lcp/interpret.wgsl"))
            .include(fragment!("lcp/numbers.wgsl"))
            .include(fragment!("lcp/jacobian.wgsl"))
            .include(fragment!("lcp/main_small.wgsl"));
        match self.slots.coupling {
            Some(_) => source
                .integer("ENTRIES_BINDING", 7)
                .include(fragment!("lcp/pair_block.wgsl"))
                .include(fragment!("lcp/small_pairs.wgsl")),
            None => source.text("fn run_pairs(place: u32, pairs: u32, local: u32) {}\n"),
        }
    }

    pub fn prepare_rows(&self) -> Source {
        self.source("prepare-rows", WORKGROUP).include(fragment!("lcp/prepare_rows.wgsl"))
    }

    pub fn prepare_entries(&self) -> Source {
        self.source("prepare-entries", WORKGROUP).include(fragment!("lcp/prepare_entries.wgsl"))
    }

    pub fn prepare_pairs(&self) -> Source {
        self.source("prepare-pairs", WORKGROUP).include(fragment!("lcp/prepare_pairs.wgsl"))
    }
}

#[cfg(test)]
mod tests {
    use super::super::number::Number;
    use super::super::shape::StageArguments;
    use super::super::tape::Tape;
    use super::*;
    use crate::gpu::validate;
    use crate::lcp::SolverKind;

    fn check(source: &Source) {
        validate(source).unwrap_or_else(|e| panic!("{} {:?}: {e}", source.name(), source.precision()));
    }

    fn variants() -> Vec<Variant> {
        let mut all = Vec::new();
        for precision in [Precision::F32, Precision::F64] {
            for planar in [true, false] {
                for kind in [SolverKind::Auto, SolverKind::Bbpgd, SolverKind::ProjectedJacobi] {
                    all.push(Variant { precision, planar, slots: Slots::of(kind) });
                }
            }
        }
        all
    }

    #[test]
    fn sources_are_valid() {
        for v in variants() {
            let common = [v.bodies(), v.finish(), v.small(), v.prepare_rows(), v.prepare_entries()];
            common.iter().for_each(check);
            if v.slots.coupling.is_some() {
                check(&v.prepare_pairs());
            }
        }
    }

    #[test]
    fn generated_sources_are_valid() {
        // All actions before and after pairs, and after a product, with constants and with computed numbers.
        let mut tape = Tape::default();
        let computed = tape.sum(Action::Dot, [7, 8, 8]);
        let all = |tape: &mut Tape| {
            for action in Action::ALL {
                if action.is_sum() {
                    tape.sum(action, [7, 8, 9]);
                } else {
                    tape.row(action, 10, [7, 8, 9], [computed, Number::Known(-1.5)]);
                }
            }
        };
        all(&mut tape);
        tape.pairs(7, computed, 8, 11);
        all(&mut tape);
        tape.product(7, 10, true);
        all(&mut tape);
        tape.finish();
        let arguments: Vec<StageArguments> =
            tape.stages.iter().filter_map(|stage| StageArguments::of(&tape, stage)).collect();
        assert!(
            arguments.iter().any(|arguments| arguments.shape.has_block())
                && arguments.iter().any(|arguments| arguments.shape.has_product())
        );
        for v in variants() {
            let has_blocks = v.slots.coupling.is_some();
            arguments
                .iter()
                .filter(|arguments| has_blocks || !arguments.shape.has_block())
                .for_each(|arguments| check(&v.stage(&arguments.shape)));
        }
    }
}
