//! The sources of the kernels of rows by branches: the choice of the branches of each pair that get a row, their
//! contacts, their rows, and the multipliers that are stored for the next step.

use super::Setup;
use super::source::sheared::beside_images;
use super::source::{base, changing, numbers, of_pairs, spinning, with_flags};
use crate::backend::cpu::first::{AHEAD, DEEPEST_AHEAD};
use crate::gpu::{Source, fragment};
use crate::separation::branches::gpu::Branched;
use crate::shape::gpu::add_shapes_to;

/// A bit in the number of a branch, set for a first row.
pub(super) const FIRST_ROW: u32 = 1 << 3;

fn numbered(setup: &Setup, source: Source) -> Source {
    source.integer("BRANCHES", setup.branches).integer("FIRST_ROW", FIRST_ROW)
}

pub(super) fn plain(setup: &Setup, name: &str) -> Source {
    numbered(setup, base(setup, name))
}

/// A source with the functions for branches of pairs.
pub(super) fn geometry(setup: &Setup, name: &str) -> Source {
    Branched::of(&setup.shapes).add_to(numbered(setup, of_pairs(setup, name)))
}

/// Adds `last_turning`: the angular velocity stored in a state.
fn with_turning(setup: &Setup, source: Source) -> Source {
    let (source, kept) = match setup.keeps_momentum() {
        true => {
            let source = spinning(setup, add_shapes_to(source));
            (source, "velocity_of(moments_of(shape), q, kept)")
        }
        false => (source, "kept"),
    };
    source.text(&format!("fn last_turning(shape: vec4r, q: vec4r, kept: vec3r) -> vec3r {{ return {kept}; }}\n"))
}

/// The kernel that carries the multipliers of branches to a new list of pairs.
pub(super) fn carry_branches(setup: &Setup) -> Source {
    plain(setup, "carry branches").include(fragment!("constraint/carry_branches.wgsl"))
}

/// The kernel that chooses the branches of pairs that get a row.
pub(super) fn choose(setup: &Setup) -> Source {
    let source = with_flags(with_turning(setup, numbers(geometry(setup, "branches"))));
    let source = source.include(fragment!("constraint/branches.wgsl"));
    changing(setup, beside_images(setup, source, "start_twists[2u * b].xyz - start_twists[2u * a].xyz"))
}

/// The kernel that aims first rows at the end of the step.
pub(super) fn aim(setup: &Setup) -> Source {
    let source = numbers(geometry(setup, "aim"))
        .real("AHEAD", AHEAD)
        .real("MOST_AIMED", DEEPEST_AHEAD * setup.thinnest)
        .include(fragment!("constraint/aim.wgsl"));
    changing(setup, source)
}
