//! The common parts of every kernel of a step: the scene's constants, forces and contact law.

pub(super) mod dragged;
pub(super) mod loads;
pub(super) mod sheared;
#[cfg(test)]
mod tests;

use super::Setup;
use crate::dynamics::{Drag, Dynamics, Force, LAST_STEP};
use crate::gpu::{LatticePeriods, Precision, Source, fragment};
use crate::separation;
use crate::shape::gpu::add_shapes_to;
use crate::walls::AtSurface;

/// Flags of a pair's contact: apart, within the limit, and overlapping by more than the tolerance. Kernels store them
/// as the last number of three vectors, so they are constants of type `real` there ([`with_flags`]).
const FAR: u32 = 0;
pub(super) const NEAR: u32 = 1;
pub(super) const VIOLATING: u32 = 2;

/// The separation that marks a normal from which no search starts (`shaders/separation/narrow.wgsl`): larger than any
/// real one, a power of two.
pub(super) const ONLY_DIRECTION: f64 = (1_u128 << 120) as f64;

/// [`LAST_STEP`] in 32-bit floats: Newton's next step is its square, which is below rounding.
const LAST_STEP_F32: f64 = 2e-4;

/// A source with the constants of the scene.
pub(super) fn base(setup: &Setup, name: &str) -> Source {
    constants(setup, setup.lattice.define(Source::new(name, setup.precision)))
}

fn constants(setup: &Setup, source: Source) -> Source {
    let source = setup.exponents.add_to(source);
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
        Dynamics::Overdamped { drag: Drag::Even(xi) } => {
            source.real("DRAG", xi).include(fragment!("dynamics/overdamped.wgsl"))
        }
        Dynamics::Overdamped { drag } => dragged::overdamped(source, drag),
        Dynamics::Inertial { density, drag: None } => {
            spinning(setup, source).real("DENSITY", density).include(fragment!("dynamics/inertial.wgsl"))
        }
        Dynamics::Inertial { density, drag: Some(drag) } => {
            let source = damped(spinning(setup, source), density, drag);
            match drag {
                Drag::Even(_) => source.include(fragment!("dynamics/damped.wgsl")),
                _ => dragged::damped(source),
            }
        }
    };
    let source = match setup.forces.iter().any(Force::is_radial) {
        true => source.include(fragment!("dynamics/radial.wgsl")),
        false => source,
    };
    let source = match &setup.stream {
        Some(stream) => loads::flowing(stream, setup.dynamics.any_drag(), source),
        None => source,
    };
    let source = match setup.strained() {
        Some(_) => loads::straining(setup.dynamics.any_drag(), source),
        None => source,
    };
    let loads = loads::load_of(setup, &source);
    let source = source.integer("SHARES", loads::windows(&setup.forces).len().div_ceil(4) as u32).text(&loads);
    let source = source.include(fragment!("dynamics/axis.wgsl")).include(fragment!("dynamics/motion.wgsl"));
    dragged::keeping(setup, source)
}

/// Moves the rows of an array with elements of this WGSL type.
pub(super) fn moved(setup: &Setup, name: &str, element: &str, per_row: u32) -> Source {
    base(setup, name)
        .text(&format!("alias Element = {element};\n"))
        .integer("PER_ROW", per_row)
        .include(fragment!("constraint/move.wgsl"))
}

pub(super) fn reporting(source: Source) -> Source {
    source.include(fragment!("step/report.wgsl"))
}

pub(super) fn with_factor(setup: &Setup, name: &str) -> Source {
    base(setup, name).include(fragment!("dynamics/factor.wgsl"))
}

/// Adds the part of a row for each of its bodies.
pub(super) fn with_parts(setup: &Setup, source: Source) -> Source {
    let source = source
        .include(fragment!("dynamics/factor.wgsl"))
        .include(fragment!("dynamics/axis.wgsl"))
        .include(fragment!("constraint/part.wgsl"));
    dragged::of_rows(setup, source)
}

/// A complete kernel that compares two bodies, adapted to periods that may change.
pub(super) fn changing(setup: &Setup, source: Source) -> Source {
    if setup.strain.is_some() { LatticePeriods::changing(source) } else { source }
}

/// The kernels of the pairs of families that the scene's shapes can form.
pub(super) fn narrow_sources(setup: &Setup) -> Vec<Source> {
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
pub(super) fn turned(setup: &Setup, name: &str) -> Source {
    spinning(setup, add_shapes_to(base(setup, name)))
}

/// Adds the effect of drag on a motion with inertia.
pub(super) fn damped(source: Source, density: f64, drag: Drag) -> Source {
    match drag {
        Drag::Even(xi) => source.real("DENSITY", density).real("DRAG", xi).include(fragment!("dynamics/damping.wgsl")),
        drag => dragged::damping(source, density, drag),
    }
}

/// A function that makes sources with torque-free rotation and drag; `None` for a scene without drag and inertia.
pub(super) fn damping(setup: &Setup) -> Option<impl Fn(&str) -> Source + '_> {
    let (density, drag) = (setup.dynamics.density()?, setup.dynamics.drag_beside_inertia()?);
    Some(move |name: &str| damped(turned(setup, name), density, drag))
}

/// A source with the changes of separations by growth.
pub(super) fn stretched(setup: &Setup) -> Source {
    let source = add_shapes_to(numbers(base(setup, "stretch")));
    match setup.grows_ellipsoids() {
        true => source.include(fragment!("dynamics/stretched_ellipsoids.wgsl")),
        false => source.include(fragment!("dynamics/stretched.wgsl")),
    }
}
