//! The kernels of one solver, assembled for a number type, a dimension and a solver kind.

use super::elements::Elements;
use super::layout::{GRID_WORDS, HALT, LOOKS, MOST_EXACT, NUMBERS, Parameters, REDUCTIONS, Slots, Variant};
use super::memory::Memory;
use super::number::{Operation, RING};
use super::problem::DeviceProblem;
use super::shape::{Shape, ShapeWork};
use super::stage::{Action, REDUCTION_KINDS};
use super::text::straight_line;
use crate::gpu::{Gpu, GpuError, Made, Precision, Source, WORKGROUP, fragment, functions};
use crate::lcp::clusters::{COMPLIANCE, LOCAL_STEPS, MOST_BODIES, MOST_ROWS, QUIET};
use crate::lcp::pair_block_cg;
use std::collections::HashMap;

/// Invocations of the workgroup that solves a small problem, on hardware.
pub(super) const SMALL_WORKGROUP: u32 = 32;

/// The same on a software adapter: as many as fit in one of its vectors, so that no invocation waits at a barrier. With
/// 32, a solve of 21 rows in f64 took 1.8 times as long on lavapipe.
pub(super) const SMALL_WORKGROUP_ON_SOFTWARE: u32 = 8;

const _: () = assert!(SMALL_WORKGROUP_ON_SOFTWARE >= REDUCTIONS);

/// The relative addition to the diagonal of a pair's block, as on the CPU; at least this many rounding errors, because
/// the entries of a block are sums of products, each with its rounding error.
const REGULARIZATION: f64 = 1e-6;
pub(super) const ROUNDINGS: f64 = 32.0;

/// The instruction on pairs at an offset of the program.
const RUN_BLOCK: &str = "fn run_block(place: u32, pairs: u32, local: u32) {
    let i = instruction(place);
    run_pairs(i.a, i.b, i.c, i.out, pairs, local);
}
";

/// An invocation processes two rows of a cluster.
const _: () = assert!(MOST_ROWS == 2 * WORKGROUP as usize);

functions! {
    /// A kernel of a solver. It uses only some of these arguments.
    pub(super) Lcp = struct LcpArgs<'a> { dispatch: Parameters, memory: &'a Memory, problem: &'a DeviceProblem }
}

/// The kernels of a solver. Each is compiled when a problem first needs it: few scenes have both small and large
/// problems.
#[derive(Default)]
pub(super) struct Kernels {
    pub prepare_rows: Option<Lcp>,
    /// For large problems.
    pub prepare_entries: Option<Lcp>,
    /// For small problems.
    pub small: Option<Lcp>,
    /// For solvers with blocks of pairs.
    pub prepare_pairs: Option<Lcp>,
    stages: HashMap<Shape, Lcp>,
    /// For small problems, by the elements of a round.
    straight: HashMap<Vec<Shape>, Lcp>,
}

impl Kernels {
    /// Compiles the kernels that every small problem needs, or every large one.
    pub fn make_common(&mut self, gpu: &Gpu, variant: Variant, small: bool) -> Result<(), GpuError> {
        let kernel = |source: Source| Lcp::make(gpu, source);
        if self.prepare_rows.is_none() {
            self.prepare_rows = Some(kernel(variant.prepare_rows())?);
        }
        if self.prepare_pairs.is_none() && variant.slots.has_blocks() {
            self.prepare_pairs = Some(kernel(variant.prepare_pairs())?);
        }
        if self.small.is_none() && small {
            self.small = Some(kernel(variant.small())?);
        }
        if self.prepare_entries.is_none() && !small {
            self.prepare_entries = Some(kernel(variant.prepare_entries())?);
        }
        Ok(())
    }

    /// Compiles the kernel of a stage, unless it exists.
    pub fn make(&mut self, gpu: &Gpu, variant: Variant, shape: &Shape) -> Result<(), GpuError> {
        if !self.stages.contains_key(shape) {
            self.stages.insert(shape.clone(), Lcp::make(gpu, variant.stage(shape))?);
        }
        Ok(())
    }

    pub fn stage(&self, shape: &Shape) -> Option<&Lcp> {
        self.stages.get(shape)
    }

    /// Compiles the kernel of one workgroup's rounds, unless it exists.
    pub fn make_straight(&mut self, gpu: &Gpu, variant: Variant, shapes: &[Shape]) -> Result<(), GpuError> {
        if !self.straight.contains_key(shapes) {
            self.straight.insert(shapes.to_vec(), Lcp::make(gpu, variant.straight(shapes))?);
        }
        Ok(())
    }

    pub fn straight(&self, shapes: &[Shape]) -> Option<&Lcp> {
        self.straight.get(shapes)
    }
}

impl Variant {
    /// The properties with which a device solves such problems.
    pub fn of(gpu: &Gpu, precision: Precision, planar: bool, slots: Slots) -> Self {
        let small_workgroup = if gpu.is_software() { SMALL_WORKGROUP_ON_SOFTWARE } else { SMALL_WORKGROUP };
        Variant { precision, planar, slots, small_workgroup }
    }

    fn source(&self, name: &str, workgroup: u32) -> Source {
        let slots = &self.slots;
        let actions = &Action::ALL[..if slots.friction.is_some() { Action::ALL.len() } else { Action::OF_ROWS }];
        let shift = (ROUNDINGS * self.precision.epsilon()).max(REGULARIZATION);
        let source = Source::with_workgroup(format!("lcp-{name}"), self.precision, workgroup)
            .integer("WIDTH", if self.planar { 1 } else { 2 })
            .integer("Q", slots.q)
            .integer("DIAGONAL", slots.diagonal)
            .integer("INVERSE", slots.inverse)
            .integer("X", slots.x)
            .integer("NONE", u32::MAX)
            .integer("MAJORANT", slots.majorant.map_or(u32::MAX, |[majorant, _]| majorant))
            .integer("LOW", slots.low.unwrap_or(u32::MAX))
            .integer("COUPLING", slots.coupling.unwrap_or(u32::MAX))
            .integer("REDUCTIONS", REDUCTIONS)
            .integer("NUMBERS", NUMBERS)
            .integer("HALT", HALT)
            .integer("LOOKS", LOOKS)
            .integer("RING", RING)
            .integer("GRID_WORDS", GRID_WORDS as u32)
            .integer("MOST_EXACT", MOST_EXACT)
            .integer("FIRST_OF_PAIR", 1 << 31)
            .real("REGULARIZATION", shift)
            .real("SHIFT", 1.0 + shift)
            .real("SHIFT_OF_DETERMINANT", shift * (2.0 + shift))
            .real("LEAST_PIVOT", 0.1 * shift)
            .constants("kinds of reductions", REDUCTION_KINDS)
            .constants("actions on rows", actions.iter().map(|action| (action.constant(), *action as u32)))
            .constants("operations on numbers", Operation::ALL.map(|what| (what.constant(), what as u32)))
            .include(fragment!("lcp/parameters.wgsl"))
            .include(fragment!("lcp/cone.wgsl"));
        match slots.friction {
            Some(slots) => self.with_friction(source, slots),
            None => source,
        }
    }

    pub(super) fn elements(&self) -> Elements {
        if self.slots.friction.is_some() { Elements::Contacts } else { Elements::Rows }
    }

    fn reducing(&self, name: &str, workgroup: u32) -> Source {
        self.source(name, workgroup).include(fragment!("lcp/reduce.wgsl")).include(fragment!("lcp/arithmetic.wgsl"))
    }

    fn instructions(&self, source: Source) -> Source {
        if self.elements() == Elements::Contacts {
            return self.instructions_of_contacts(source);
        }
        let source = match self.precision {
            Precision::F32 => source.include(fragment!("lcp/two_sums.wgsl")),
            Precision::F64 => source.include(fragment!("lcp/one_part.wgsl")),
        };
        source.include(fragment!("lcp/instructions.wgsl"))
    }

    /// The kernel of a stage.
    pub fn stage(&self, shape: &Shape) -> Source {
        let name = match &shape.work {
            ShapeWork::Numbers => "numbers",
            ShapeWork::Bodies { .. } => "bodies",
            ShapeWork::Clusters { .. } => "clusters",
            ShapeWork::Rows { block: Some(_), .. } => "pairs",
            ShapeWork::Rows { product: Some(_), .. } => "product",
            ShapeWork::Rows { .. } => "rows",
        };
        let mut source = self.reducing(name, WORKGROUP).text(&shape.declarations(self.elements()));
        source = source.text("var<workgroup> halted: u32;\n");
        if !shape.taken.is_empty() {
            source = source.include(fragment!("lcp/take_sums.wgsl"));
        }
        if shape.sums() > 0 {
            source = source.include(fragment!("lcp/leave_sums.wgsl"));
        }
        if let ShapeWork::Rows { .. } = shape.work {
            source = self.instructions(source);
        }
        if shape.has_block() {
            source = match self.elements() {
                Elements::Contacts => self.in_contacts(source),
                Elements::Rows => {
                    source.include(fragment!("lcp/pairs_of_all.wgsl")).include(fragment!("lcp/pair_block.wgsl"))
                }
            };
            source = source.include(fragment!("lcp/spans.wgsl"));
        }
        if shape.gathers() {
            source = source.include(fragment!("lcp/parts.wgsl"));
        }
        if shape.is_clusters() {
            source = self.in_clusters(source);
        }
        if shape.is_exact() {
            source = source.include(fragment!("lcp/two_sums.wgsl")).include(fragment!("lcp/exact.wgsl"));
        }
        if self.elements() == Elements::Contacts {
            return self.stage_of_contacts(source, shape);
        }
        if shape.has_product() {
            source = source
                .text("fn pair_of(row: u32) -> vec2<u32> { return pair[row]; }\n")
                .include(fragment!("lcp/jacobian.wgsl"));
        }
        source = match (shape.is_bodies(), shape.has_product(), shape.is_exact()) {
            (true, _, true) => source.include(fragment!("lcp/move_bodies_exactly.wgsl")),
            (true, _, false) => source.include(fragment!("lcp/move_bodies.wgsl")),
            (_, true, true) => source.include(fragment!("lcp/product_exactly.wgsl")),
            _ => source,
        };
        let text = shape.entry_point(Elements::Rows, |x| source.literal(x));
        source.text(&text)
    }

    /// Adds the code for the local LCPs of clusters.
    fn in_clusters(&self, source: Source) -> Source {
        let shift = (pair_block_cg::ROUNDING * self.precision.epsilon()).max(pair_block_cg::REGULARIZATION);
        source
            .integer("MOST_BODIES", MOST_BODIES as u32)
            .integer("LOCAL_STEPS", LOCAL_STEPS as u32)
            .real("QUIET", QUIET)
            .real("COMPLIANCE", COMPLIANCE)
            .real("SHORTEST", pair_block_cg::SHORTEST)
            .real("LONGEST", pair_block_cg::LONGEST)
            .real("DESCENT", pair_block_cg::DESCENT)
            .real("SHIFT_OF_DIRECTIONS", 1.0 + shift)
            .include(fragment!("lcp/pairs_of_cluster.wgsl"))
            .include(fragment!("lcp/pair_block.wgsl"))
            .include(fragment!("lcp/cluster.wgsl"))
    }

    /// The code of one workgroup that solves a small problem, with or without the small problems of pairs.
    fn in_one_workgroup(&self, name: &str, pairs: bool) -> Source {
        let mut source = self
            .instructions(self.reducing(name, self.small_workgroup))
            .include(fragment!("lcp/small.wgsl"))
            .include(fragment!("lcp/jacobian.wgsl"));
        source = match self.slots.low {
            Some(_) => source
                .text("var<storage, read_write> velocity_rest: array<vec4r>;\n")
                .include(fragment!("lcp/two_sums.wgsl"))
                .include(fragment!("lcp/exact.wgsl"))
                .include(fragment!("lcp/product_exactly.wgsl"))
                .include(fragment!("lcp/small_exact.wgsl")),
            None => source.include(fragment!("lcp/small_plain.wgsl")),
        };
        if self.slots.coupling.is_some() {
            source = source.text("var<storage, read> entries: array<real>;\n");
        }
        if pairs {
            source = source
                .include(fragment!("lcp/pairs_of_all.wgsl"))
                .include(fragment!("lcp/pair_block.wgsl"))
                .include(fragment!("lcp/small_pairs.wgsl"));
        }
        source
    }

    /// The kernel of one workgroup that reads its instructions from a program.
    pub fn small(&self) -> Source {
        let numbers = match self.small_workgroup {
            SMALL_WORKGROUP_ON_SOFTWARE => fragment!("lcp/numbers_in_storage.wgsl"),
            _ => fragment!("lcp/numbers_in_workgroup.wgsl"),
        };
        let source = self
            .in_one_workgroup("small", self.slots.coupling.is_some())
            .include(numbers)
            .include(fragment!("lcp/numbers.wgsl"))
            .include(fragment!("lcp/interpret.wgsl"));
        let source = source.text(match self.slots.coupling {
            Some(_) => RUN_BLOCK,
            None => "fn run_block(place: u32, pairs: u32, local: u32) {}\n",
        });
        source.include(fragment!("lcp/main_small.wgsl"))
    }

    /// The kernel of one workgroup that executes these elements round after round.
    pub fn straight(&self, shapes: &[Shape]) -> Source {
        let source = self.in_one_workgroup("rounds", shapes.iter().any(Shape::has_block));
        let text = straight_line(shapes, |x| source.literal(x));
        source.text(&text)
    }

    pub fn prepare_rows(&self) -> Source {
        let source = self.source("prepare-rows", WORKGROUP);
        match self.elements() {
            Elements::Rows => source.include(fragment!("lcp/prepare_rows.wgsl")),
            Elements::Contacts => self.prepare_contacts(source),
        }
    }

    pub fn prepare_entries(&self) -> Source {
        let source = self.source("prepare-entries", WORKGROUP);
        match self.elements() {
            Elements::Rows => source.include(fragment!("lcp/prepare_entries.wgsl")),
            Elements::Contacts => self.prepare_entries_of_contacts(source),
        }
    }

    pub fn prepare_pairs(&self) -> Source {
        let source = self.source("prepare-pairs", WORKGROUP);
        match self.elements() {
            Elements::Rows => source.include(fragment!("lcp/prepare_pairs.wgsl")),
            Elements::Contacts => self.prepare_pairs_of_contacts(source),
        }
    }
}
