//! The common parts of every kernel of a step: the scene's constants, forces and contact law.

pub(super) mod loads;
pub(super) mod sheared;
#[cfg(test)]
mod tests;

use super::Setup;
use super::bonds::BondKernels;
use super::branch_source::BranchKernels;
use super::candidates::{Carry, FindOld, Inside, Store};
use super::effect::{self, Farthest, Pushes};
use super::first::Carried;
use super::growing::GrowthKernels;
use super::heat::{self, RandomLoads};
use super::held::HeldKernels;
use super::motions::{BodyBoxes, FreeMotion, MiddleMotion};
use super::narrow_phase::{Narrow, Overlaps};
use super::near::Stretch;
use super::passing::{Passing, Stray};
use super::row_set::{Append, Count, IncidenceCount, IncidenceFill, Move, Recall, Remember, Target, Tighten};
use super::trial::{Accept, Arrive, Sweep, TrialMove};
use super::walls::WallKernels;
use super::warm::ONLY_DIRECTION;
use crate::constraint::LEAST_ALIGNED;
use crate::dynamics::{Dynamics, Force, LAST_STEP};
use crate::gpu::{LatticePeriods, Precision, Source, fragment, kernels};
use crate::separation;
use crate::shape::gpu::add_shapes_to;
use crate::step::DEEPER;
use crate::walls::AtSurface;

/// Flags of a pair's contact: apart, within the limit, and overlapping by more than the tolerance. Kernels store them
/// as the last number of three vectors, so they are constants of type `real` there ([`with_flags`]).
const FAR: u32 = 0;
pub(super) const NEAR: u32 = 1;
pub(super) const VIOLATING: u32 = 2;

/// [`LAST_STEP`] in 32-bit floats: Newton's next step is its square, which is below rounding.
const LAST_STEP_F32: f64 = 2e-4;

/// A source with the constants of the scene.
pub(super) fn base(setup: &Setup, name: &str) -> Source {
    constants(setup, setup.lattice.define(Source::new(name, setup.precision)))
}

fn constants(setup: &Setup, source: Source) -> Source {
    source
        .real("CUTOFF", setup.cutoff)
        .integer("MOTION", setup.motion_width())
        .integer("NONE", u32::MAX)
        .flag("PLANAR", setup.planar)
        .include(fragment!("common/quaternion.wgsl"))
        .include(fragment!("common/orientation.wgsl"))
}

/// Adds the flags of contacts.
pub(super) fn with_flags(source: Source) -> Source {
    let flags = [("FAR", FAR), ("NEAR", NEAR), ("VIOLATING", VIOLATING)];
    flags.into_iter().fold(source, |source, (name, flag)| source.real(name, f64::from(flag)))
}

/// The same with the shapes of bodies for separations.
pub(super) fn with_bodies(setup: &Setup, name: &str) -> Source {
    placed(base(setup, name))
}

/// The same for kernels that compare two bodies: in periodic space differences are to the nearest image.
pub(super) fn of_pairs(setup: &Setup, name: &str) -> Source {
    placed(between(setup, name))
}

/// A source whose position differences are to the nearest image in periodic space.
pub(super) fn between(setup: &Setup, name: &str) -> Source {
    constants(setup, setup.lattice_periods.define(Source::new(name, setup.precision)))
}

fn placed(source: Source) -> Source {
    separation::gpu::add_bodies_to(source).include(fragment!("separation/placed.wgsl"))
}

/// Adds the rotation of a body without torque.
pub(super) fn spinning(setup: &Setup, source: Source) -> Source {
    let last_step = match setup.precision {
        Precision::F32 => LAST_STEP_F32,
        Precision::F64 => LAST_STEP,
    };
    let source = source.flag("KEEPS_MOMENTUM", setup.keeps_momentum()).real("LAST_STEP", last_step);
    source.include(fragment!("dynamics/spin.wgsl"))
}

/// The kernel of forces, free velocities and mobilities.
pub(super) fn motion(setup: &Setup, plugged: bool) -> Source {
    let source = base(setup, "motion").flag("PLUGGED", plugged);
    let source = add_shapes_to(source).include(fragment!("dynamics/law.wgsl"));
    let source = match setup.dynamics {
        Dynamics::Overdamped { drag } => source.real("DRAG", drag).include(fragment!("dynamics/overdamped.wgsl")),
        Dynamics::Inertial { density, drag: None } => {
            spinning(setup, source).real("DENSITY", density).include(fragment!("dynamics/inertial.wgsl"))
        }
        Dynamics::Inertial { density, drag: Some(drag) } => {
            damped(spinning(setup, source), density, drag).include(fragment!("dynamics/damped.wgsl"))
        }
    };
    let source = match setup.forces.iter().any(Force::is_radial) {
        true => source.include(fragment!("dynamics/radial.wgsl")),
        false => source,
    };
    let source = match &setup.stream {
        Some(stream) => loads::flowing(stream, source),
        None => source,
    };
    let source = match setup.strained() {
        Some(_) => loads::straining(source),
        None => source,
    };
    let loads = loads::load_of(setup, &source);
    let source = source.integer("SHARES", loads::windows(&setup.forces).len().div_ceil(4) as u32).text(&loads);
    source.include(fragment!("dynamics/axis.wgsl")).include(fragment!("dynamics/motion.wgsl"))
}

/// Moves the rows of an array with elements of this WGSL type.
pub(super) fn moved(setup: &Setup, name: &str, element: &str, per_row: u32) -> Source {
    base(setup, name)
        .text(&format!("alias Element = {element};\n"))
        .integer("PER_ROW", per_row)
        .include(fragment!("constraint/move.wgsl"))
}

kernels! {
    /// The kernels of a step.
    pub(super) struct Kernels for setup: &Setup {
        motion: FreeMotion = motion(setup, setup.makes_loads()),
        boxes: BodyBoxes = with_bodies(setup, "box").include(fragment!("broad_phase/box.wgsl")),
        sweep: Sweep = with_bodies(setup, "sweep").include(fragment!("broad_phase/sweep.wgsl")),
        inside: Inside = reporting(base(setup, "inside")).include(fragment!("broad_phase/inside.wgsl")),
        store: Store = base(setup, "store").include(fragment!("broad_phase/store.wgsl")),
        trial: TrialMove = with_factor(setup, "trial").include(fragment!("dynamics/trial.wgsl")),
        accept: Accept = base(setup, "accept").include(fragment!("dynamics/accept.wgsl")),
        /// One kernel for each pair of families that the scene's shapes can form.
        narrow: Vec<Narrow> = narrow_sources(setup),
        overlap: Overlaps =
            reporting(with_flags(base(setup, "overlap"))).include(fragment!("step/overlap.wgsl")),
        farthest: Farthest = effect::farthest(setup),
        pushes: Option<Pushes> = effect::pushes(setup),
        stray: Stray = reporting(with_bodies(setup, "stray")).include(fragment!("step/stray.wgsl")),
        passing: Passing = passing(setup),
        target: Target = base(setup, "target").include(fragment!("constraint/target.wgsl")),
        move_pairs: Move = moved(setup, "move pairs", "vec2<u32>", 1),
        move_blocks: Move = moved(setup, "move blocks", "vec4r", if setup.planar { 2 } else { 4 }),
        move_reals: Move = moved(setup, "move numbers", "real", 1),
        incidence_count: IncidenceCount = base(setup, "incidence count").include(fragment!("constraint/incidence_count.wgsl")),
        incidence_fill: IncidenceFill = base(setup, "incidence fill").include(fragment!("constraint/incidence_fill.wgsl")),
        find: FindOld = numbers(base(setup, "find")).include(fragment!("constraint/find.wgsl")),
        carry: Carry = base(setup, "carry").include(fragment!("constraint/carry.wgsl")),
        /// With inertia, instead of `accept`.
        arrive: Option<Arrive> =
            setup.inertia().then(|| match damping(setup) {
                Some(source) => source("arrive").include(fragment!("dynamics/damped_arrive.wgsl")),
                None => turned(setup, "arrive").include(fragment!("dynamics/arrive.wgsl")),
            }),
        /// In scenes with growth.
        growth: Option<GrowthKernels> = setup.growth.is_some().then_some(setup),
        /// In scenes with walls.
        walls: Option<WallKernels> = (!setup.walls.is_empty()).then_some(setup),
        /// With midpoint steps.
        midpoint: Option<MidpointKernels> = setup.midpoint.then_some(setup),
        /// In scenes with bonds.
        bonds: Option<BondKernels> = (!setup.bonds.is_empty()).then_some(setup),
        /// In scenes with a changing cell.
        carried: Option<Carried> = setup.strain.map(|_| sheared::carried(setup)),
        /// In scenes with Brownian motion.
        heat: Option<RandomLoads> = heat::source(setup),
        /// In scenes with fixed bodies.
        held: Option<HeldKernels> = setup.fixed.then_some(setup),
        /// With the paper's rows.
        paper: Option<PaperKernels> = (setup.branches == 0).then_some(setup),
        /// With rows by branches.
        branches: Option<BranchKernels> = (setup.branches > 0).then_some(setup),
    }
}

kernels! {
    /// The kernels of the middle of a step.
    pub(super) struct MidpointKernels for setup: &Setup {
        /// With the paper's rows.
        rows: Option<MiddleRowKernels> = (setup.branches == 0).then_some(setup),
        /// The motion over the step, with inertia.
        middle: Option<MiddleMotion> =
            setup.inertia().then(|| match damping(setup) {
                Some(source) => source("middle").include(fragment!("dynamics/damped_middle.wgsl")),
                None => turned(setup, "middle").include(fragment!("dynamics/middle.wgsl")),
            }),
        /// The separations at later lengths, in scenes with growth and the paper's rows.
        stretch: Option<Stretch> = (setup.branches == 0 && setup.growth.is_some())
            .then(|| stretched(setup).include(fragment!("dynamics/stretch.wgsl"))),
    }
}

kernels! {
    /// The kernels of the paper's rows.
    pub(super) struct PaperKernels for setup: &Setup {
        count: Count = base(setup, "count").include(fragment!("constraint/count.wgsl")),
        append: Append = with_parts(numbers(base(setup, "append")))
            .include(fragment!("constraint/row.wgsl"))
            .include(fragment!("constraint/append.wgsl")),
        remember: Remember =
            with_direction(base(setup, "remember")).include(fragment!("constraint/remember.wgsl")),
    }
}

kernels! {
    /// The kernels of the paper's rows in the middle of a step.
    pub(super) struct MiddleRowKernels for setup: &Setup {
        /// The starting multipliers of these rows.
        recall: Recall = base(setup, "recall").include(fragment!("constraint/recall.wgsl")),
        tighten: Tighten = with_parts(with_flags(base(setup, "tighten")).real("LEAST_ALIGNED", LEAST_ALIGNED))
            .include(fragment!("constraint/share.wgsl"))
            .include(fragment!("constraint/tighten.wgsl")),
    }
}

pub(super) fn reporting(source: Source) -> Source {
    source.include(fragment!("step/report.wgsl"))
}

fn with_factor(setup: &Setup, name: &str) -> Source {
    base(setup, name).include(fragment!("dynamics/factor.wgsl"))
}

/// Adds the part of a row for each of its bodies.
pub(super) fn with_parts(source: Source) -> Source {
    source
        .include(fragment!("dynamics/factor.wgsl"))
        .include(fragment!("dynamics/axis.wgsl"))
        .include(fragment!("constraint/part.wgsl"))
}

/// The kernel that finds pairs that may have tunnelled.
fn passing(setup: &Setup) -> Source {
    let source = reporting(of_pairs(setup, "passing")).real("DEEPER", DEEPER).include(fragment!("step/passing.wgsl"));
    changing(setup, sheared::beside_images(setup, source, "motions[first_b].xyz - motions[first_a].xyz"))
}

/// A complete kernel that compares two bodies, adapted to periods that may change.
pub(super) fn changing(setup: &Setup, source: Source) -> Source {
    if setup.strain.is_some() { LatticePeriods::changing(source) } else { source }
}

/// The kernels of the pairs of families that the scene's shapes can form.
fn narrow_sources(setup: &Setup) -> Vec<Source> {
    let families = separation::gpu::PairFamilies::needed(setup.shapes.iter().copied());
    let source = |(k, families): (usize, separation::gpu::PairFamilies)| {
        let source = with_direction(with_flags(of_pairs(setup, &format!("separations {k}"))));
        let source = source.real("GAP", setup.gap());
        let near = match setup.branches {
            0 => fragment!("separation/near_boxes.wgsl"),
            _ => fragment!("separation/near_motions.wgsl"),
        };
        let source = families.add_to(source, setup.planar).include(near);
        let source = source.include(fragment!("step/report.wgsl")).include(fragment!("separation/narrow.wgsl"));
        changing(setup, source)
    };
    families.into_iter().enumerate().map(source).collect()
}

/// Adds the separation that marks a normal from which no search starts.
pub(super) fn with_direction(source: Source) -> Source {
    source.real("ONLY_DIRECTION", ONLY_DIRECTION)
}

/// Adds the numbers of surfaces, which replace the second body of a pair.
pub(super) fn numbers(source: Source) -> Source {
    source
        .constants("numbers of surfaces", [("FIRST_SURFACE", AtSurface::FIRST), ("PLACES", AtSurface::PLACES)])
        .include(fragment!("walls/number.wgsl"))
}

/// A source with the rotation of the scene's bodies without torque.
fn turned(setup: &Setup, name: &str) -> Source {
    spinning(setup, add_shapes_to(base(setup, name)))
}

/// Adds the effect of drag on a motion with inertia.
pub(super) fn damped(source: Source, density: f64, drag: f64) -> Source {
    source.real("DENSITY", density).real("DRAG", drag).include(fragment!("dynamics/damping.wgsl"))
}

/// A function that makes sources with torque-free rotation and drag; `None` for a scene without drag and inertia.
fn damping(setup: &Setup) -> Option<impl Fn(&str) -> Source + '_> {
    let (density, drag) = (setup.dynamics.density()?, setup.dynamics.drag_beside_inertia()?);
    Some(move |name: &str| damped(turned(setup, name), density, drag))
}

/// A source with the changes of separations by growth.
pub(super) fn stretched(setup: &Setup) -> Source {
    add_shapes_to(numbers(base(setup, "stretch"))).include(fragment!("dynamics/stretched.wgsl"))
}
