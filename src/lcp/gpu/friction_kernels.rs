//! The kernels of contacts with friction: what differs from those of rows alone.

use super::elements::Elements;
use super::kernels::ROUNDINGS;
use super::layout::{BLOCK_WORDS, FrictionSlots, Variant, rows_of_contact, unit_words};
use super::shape::Shape;
use crate::gpu::{Source, fragment};
use crate::lcp::friction::constants as friction;

impl Variant {
    /// Adds what all kernels of contacts with friction share.
    pub(super) fn with_friction(&self, source: Source, slots: FrictionSlots) -> Source {
        let rounding = ROUNDINGS * self.precision.epsilon();
        source
            .integer("COMPLIANCE_AT", slots.compliance)
            .integer("CORRECTION_AT", slots.correction)
            .integer("SCRATCH_AT", slots.scratch)
            .integer("ROWS", rows_of_contact(self.planar))
            .integer("BLOCK_WORDS", BLOCK_WORDS)
            .integer("UNIT_WORDS", unit_words(self.planar))
            .real("ON_BOUNDARY", friction::ON_BOUNDARY.max(rounding))
            .real("ROUNDING", friction::ROUNDING.max(rounding))
            .include(fragment!("lcp/friction/cone.wgsl"))
    }

    /// Adds the small problems of pairs of contacts with friction.
    pub(super) fn in_contacts(&self, source: Source) -> Source {
        source
            .integer("MOST_ROUNDS", friction::MOST_ROUNDS as u32)
            .integer("SWEEPS", friction::SWEEPS as u32)
            .real("SETTLED", friction::SETTLED)
            .real("CONVERGED", friction::CONVERGED.max(ROUNDINGS * self.precision.epsilon()))
            .include(fragment!("lcp/friction/block.wgsl"))
            .include(fragment!("lcp/friction/pair_block.wgsl"))
    }

    /// The rest of the kernel of a stage on contacts with friction.
    pub(super) fn stage_of_contacts(&self, mut source: Source, shape: &Shape) -> Source {
        if shape.has_product() {
            source = source.include(fragment!("lcp/friction/jacobian.wgsl"));
        }
        if shape.is_bodies() {
            source = source.include(fragment!("lcp/friction/move_bodies.wgsl"));
        }
        let text = shape.entry_point(Elements::Contacts, |x| source.literal(x));
        source.text(&text)
    }

    /// Adds the instructions on contacts.
    pub(super) fn instructions_of_contacts(&self, source: Source) -> Source {
        source
            .real("SMALLEST", friction::SMALLEST)
            .real("GROWTH", friction::GROWTH)
            .include(fragment!("lcp/friction/instructions.wgsl"))
    }

    pub(super) fn prepare_contacts(&self, source: Source) -> Source {
        source
            .include(fragment!("lcp/friction/prepare_rows.wgsl"))
            .include(fragment!("lcp/friction/blocks_of_rows.wgsl"))
    }

    pub(super) fn prepare_entries_of_contacts(&self, source: Source) -> Source {
        source
            .include(fragment!("lcp/friction/prepare_entries.wgsl"))
            .include(fragment!("lcp/friction/blocks_of_rows.wgsl"))
    }

    pub(super) fn prepare_pairs_of_contacts(&self, source: Source) -> Source {
        source
            .integer("MOST_SWEEPS", friction::MOST_SWEEPS as u32)
            .real("NEGLIGIBLE", friction::NEGLIGIBLE * self.precision.epsilon())
            .include(fragment!("lcp/friction/prepare_pairs.wgsl"))
            .include(fragment!("lcp/friction/blocks_of_rows.wgsl"))
    }
}
