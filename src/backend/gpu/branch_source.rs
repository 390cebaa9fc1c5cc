//! The kernels of rows by branches: the choice of the branches of each pair that get a row, their contacts, their rows,
//! and the multipliers that are stored for the next step.

use super::Setup;
use super::branches::{
    Aim, AppendBranches, CarryBranches, Choose, CountBranches, Match, RememberBranches, Stage, StartBranches,
    StretchBranches, TightenBranches, Tightened,
};
use super::first::Ahead;
use super::row_set::Move;
use super::source::sheared::beside_images;
use super::source::{base, changing, moved, numbers, of_pairs, spinning, stretched};
use super::source::{with_direction, with_flags, with_parts};
use crate::backend::cpu::first::{AHEAD, DEEPEST_AHEAD};
use crate::constraint::LEAST_ALIGNED;
use crate::gpu::{Source, fragment, kernels};
use crate::separation::branches::gpu::Branched;
use crate::shape::gpu::add_shapes_to;

/// A bit in the number of a branch, set for a first row.
pub(super) const FIRST_ROW: u32 = 1 << 3;

kernels! {
    /// The kernels of a scene whose rows are by branches.
    pub(super) struct BranchKernels for setup: &Setup {
        choose: Choose = choose(setup),
        count: CountBranches = plain(setup, "count").include(fragment!("constraint/count_branches.wgsl")),
        append: AppendBranches = with_parts(numbers(plain(setup, "append")))
            .include(fragment!("constraint/row.wgsl"))
            .include(fragment!("constraint/append_branches.wgsl")),
        remember: RememberBranches = with_direction(plain(setup, "remember"))
            .include(fragment!("constraint/remember_branches.wgsl")),
        stage: Stage = changing(setup, geometry(setup, "stage").include(fragment!("constraint/stage.wgsl"))),
        start: StartBranches = plain(setup, "start").include(fragment!("constraint/start_branches.wgsl")),
        carry: CarryBranches = plain(setup, "carry branches").include(fragment!("constraint/carry_branches.wgsl")),
        matched: Match = plain(setup, "match").include(fragment!("constraint/match.wgsl")),
        tighten: TightenBranches = with_parts(plain(setup, "tighten").real("LEAST_ALIGNED", LEAST_ALIGNED))
            .include(fragment!("constraint/share.wgsl"))
            .include(fragment!("constraint/tighten_branches.wgsl")),
        tightened: Tightened = plain(setup, "tightened").include(fragment!("constraint/tightened.wgsl")),
        move_words: Move = moved(setup, "move words", "u32", 1),
        /// Only if first rows are made at positions extrapolated with the last velocities.
        ahead: Option<Ahead> = setup.leads_ahead()
            .then(|| base(setup, "ahead").real("AHEAD", AHEAD).include(fragment!("dynamics/ahead.wgsl"))),
        /// Only in that case, and if the separation of some branches follows from their number.
        aim: Option<Aim> = (setup.leads_ahead() && Branched::of(&setup.shapes).has_ends()).then(|| aim(setup)),
        /// Updates staged contacts to later lengths, in scenes with growth and midpoint steps.
        stretch: Option<StretchBranches> = (setup.midpoint && setup.growth.is_some())
            .then(|| stretched(setup).include(fragment!("dynamics/stretch_branches.wgsl"))),
    }
}

fn numbered(setup: &Setup, source: Source) -> Source {
    source.integer("BRANCHES", setup.branches).integer("FIRST_ROW", FIRST_ROW)
}

fn plain(setup: &Setup, name: &str) -> Source {
    numbered(setup, base(setup, name))
}

/// A source with the functions for branches of pairs.
fn geometry(setup: &Setup, name: &str) -> Source {
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

/// The kernel that chooses the branches of pairs that get a row.
fn choose(setup: &Setup) -> Source {
    let source = with_flags(with_turning(setup, numbers(geometry(setup, "branches"))));
    let source = source.include(fragment!("constraint/branches.wgsl"));
    changing(setup, beside_images(setup, source, "start_twists[2u * b].xyz - start_twists[2u * a].xyz"))
}

/// The kernel that aims first rows at the end of the step.
fn aim(setup: &Setup) -> Source {
    let source = numbers(geometry(setup, "aim"))
        .real("AHEAD", AHEAD)
        .real("MOST_AIMED", DEEPEST_AHEAD * setup.thinnest)
        .include(fragment!("constraint/aim.wgsl"));
    changing(setup, source)
}
