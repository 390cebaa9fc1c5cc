//! The kernels of rows by branches: which branches of each pair get a row, their contacts, their rows, and what of them
//! is remembered.

use super::Setup;
use super::source::{NEAR, VIOLATING, base, moved, numbers, of_pairs, spinning};
use crate::backend::cpu::first::{AHEAD, DEEPEST_AHEAD};
use crate::constraint::LEAST_ALIGNED;
use crate::gpu::{Gpu, GpuError, Kernel, Source, fragment};
use crate::separation::branches::{DEEPEST, LEAST_SLACK, ROUNDING, SLACK_IN_SPACE};
use crate::separation::gpu::add_tolerances_to;

/// Set in the number of a first row's branch.
pub(super) const FIRST_ROW: u32 = 1 << 3;

/// Two ways to compute a distance differ by less than this many roundings of the sizes: by 2.1 at most in 7 million
/// random pairs of rods, aspect 1.5 to 100.
const ROUNDINGS: f64 = 8.0;

/// The kernels of a scene whose rows are by branches, beside those that have others for that.
pub(super) struct BranchKernels {
    pub choose: Kernel,
    pub stage: Kernel,
    pub start: Kernel,
    pub carry: Kernel,
    pub matched: Kernel,
    pub tighten: Kernel,
    pub tightened: Kernel,
    pub move_words: Kernel,
    /// Where first rows are made where the last velocities lead.
    pub ahead: Option<Kernel>,
    /// Where they are, and pairs have several branches.
    pub aim: Option<Kernel>,
    /// Where bodies grow and steps have a middle.
    pub stretch: Option<Kernel>,
}

impl BranchKernels {
    /// Those of a scene; none where it has the paper's rows.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Option<Self>, GpuError> {
        if setup.branches == 0 {
            return Ok(None);
        }
        let make = |source: &Source| Kernel::new(gpu, source);
        let [choose, stage, start, carry, matched, tighten, tightened, move_words] = &branch_sources(setup);
        Ok(Some(BranchKernels {
            choose: make(choose)?,
            stage: make(stage)?,
            start: make(start)?,
            carry: make(carry)?,
            matched: make(matched)?,
            tighten: make(tighten)?,
            tightened: make(tightened)?,
            move_words: make(move_words)?,
            ahead: ahead(setup).as_ref().map(make).transpose()?,
            aim: aim(setup).as_ref().map(make).transpose()?,
            stretch: stretch(setup).as_ref().map(make).transpose()?,
        }))
    }
}

fn numbered(setup: &Setup, source: Source) -> Source {
    source.integer("BRANCHES", setup.branches).integer("FIRST_ROW", FIRST_ROW)
}

fn plain(setup: &Setup, name: &str) -> Source {
    numbered(setup, base(setup, name))
}

/// A source that knows the branches of pairs.
fn geometry(setup: &Setup, name: &str) -> Source {
    let rounding = (ROUNDINGS * setup.precision.epsilon()).max(ROUNDING);
    let source = add_tolerances_to(numbered(setup, of_pairs(setup, name)))
        .flag("RODS", setup.branches > 1)
        .real("DEEPEST", DEEPEST)
        .real("LEAST_SLACK", LEAST_SLACK)
        .real("SLACK_IN_SPACE", SLACK_IN_SPACE)
        .real("BRANCH_ROUNDING", rounding);
    source.include(fragment!("separation/branches.wgsl"))
}

/// `last_turning`: the angular velocity that a state keeps.
fn with_turning(setup: &Setup, source: Source) -> Source {
    let (source, kept) = match setup.keeps_momentum() {
        true => {
            let source = spinning(setup, source.include(fragment!("shape/shape.wgsl")));
            (source, "velocity_of(moments_of(shape), q, kept)")
        }
        false => (source, "kept"),
    };
    source.text(&format!("fn last_turning(shape: vec4r, q: vec4r, kept: vec3r) -> vec3r {{ return {kept}; }}\n"))
}

/// The kernel of how many rows pairs will have.
pub(super) fn count(setup: &Setup) -> Source {
    plain(setup, "count").include(fragment!("constraint/count_branches.wgsl"))
}

/// The kernel that makes rows.
pub(super) fn append(setup: &Setup) -> Source {
    numbers(plain(setup, "append"))
        .include(fragment!("dynamics/factor.wgsl"))
        .include(fragment!("constraint/part.wgsl"))
        .include(fragment!("constraint/row.wgsl"))
        .include(fragment!("constraint/append_branches.wgsl"))
}

/// The kernel of what the next step starts from.
pub(super) fn remember(setup: &Setup) -> Source {
    plain(setup, "remember").include(fragment!("constraint/remember_branches.wgsl"))
}

/// The kernels that every scene with branches needs, in the order of [`BranchKernels`].
pub(super) fn branch_sources(setup: &Setup) -> [Source; 8] {
    let choose = with_turning(setup, numbers(geometry(setup, "branches"))).real("NEAR", NEAR);
    let tighten = plain(setup, "tighten").real("LEAST_ALIGNED", LEAST_ALIGNED);
    let tighten = tighten.include(fragment!("dynamics/factor.wgsl")).include(fragment!("constraint/part.wgsl"));
    [
        choose.real("VIOLATING", VIOLATING).include(fragment!("constraint/branches.wgsl")),
        geometry(setup, "stage").include(fragment!("constraint/stage.wgsl")),
        plain(setup, "start").include(fragment!("constraint/start_branches.wgsl")),
        plain(setup, "carry branches").include(fragment!("constraint/carry_branches.wgsl")),
        plain(setup, "match").include(fragment!("constraint/match.wgsl")),
        tighten.include(fragment!("constraint/share.wgsl")).include(fragment!("constraint/tighten_branches.wgsl")),
        plain(setup, "tightened").include(fragment!("constraint/tightened.wgsl")),
        moved(setup, "move words", "u32", 1),
    ]
}

/// The kernel that leads bodies to where first rows are made.
pub(super) fn ahead(setup: &Setup) -> Option<Source> {
    setup.leads_ahead().then(|| base(setup, "ahead").real("AHEAD", AHEAD).include(fragment!("dynamics/ahead.wgsl")))
}

/// The kernel that aims first rows at the end of the step.
pub(super) fn aim(setup: &Setup) -> Option<Source> {
    let source =
        || numbers(geometry(setup, "aim")).real("AHEAD", AHEAD).real("MOST_AIMED", DEEPEST_AHEAD * setup.thinnest());
    let needed = setup.leads_ahead() && setup.branches > 1;
    needed.then(|| source().include(fragment!("constraint/aim.wgsl")))
}

/// The kernel of staged contacts at later lengths.
pub(super) fn stretch(setup: &Setup) -> Option<Source> {
    let shaped = || numbers(base(setup, "stretch")).include(fragment!("shape/shape.wgsl"));
    let stretched = || shaped().include(fragment!("dynamics/stretched.wgsl"));
    let needed = setup.branches > 0 && setup.midpoint && setup.growth.is_some();
    needed.then(|| stretched().include(fragment!("dynamics/stretch_branches.wgsl")))
}
