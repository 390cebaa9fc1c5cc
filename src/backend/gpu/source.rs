//! What every kernel of a step is assembled with: the scene's constants, forces and law.

#[cfg(test)]
mod tests;

use super::Setup;
use super::branch_source::{self, BranchKernels};
use super::walls::FIRST_SURFACE;
use crate::constraint::LEAST_ALIGNED;
use crate::dynamics::{Dynamics, Force, LAST_STEP};
use crate::gpu::{Gpu, GpuError, Kernel, Precision, Source, fragment};
use crate::separation;
use std::fmt::Write as _;

/// Flags of a pair's contact, as in `shaders/separation/narrow.wgsl`.
pub(super) const NEAR: f64 = 1.0;
pub(super) const VIOLATING: f64 = 2.0;

/// [`LAST_STEP`] in 32-bit floats: the next of Newton's steps is its square, below a rounding.
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

/// The same with shapes as separations know them.
pub(super) fn with_bodies(setup: &Setup, name: &str) -> Source {
    placed(base(setup, name))
}

/// The same for kernels that compare two bodies: in periodic space differences are to the nearest image.
pub(super) fn of_pairs(setup: &Setup, name: &str) -> Source {
    placed(constants(setup, setup.lattice_periods.define(Source::new(name, setup.precision))))
}

fn placed(source: Source) -> Source {
    separation::gpu::add_bodies_to(source).include(fragment!("separation/placed.wgsl"))
}

/// Adds how a body turns without torque.
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
    let source = base(setup, "motion")
        .flag("PLUGGED", plugged)
        .include(fragment!("shape/shape.wgsl"))
        .include(fragment!("dynamics/law.wgsl"));
    let source = match setup.dynamics {
        Dynamics::Overdamped { drag } => source.real("DRAG", drag).include(fragment!("dynamics/overdamped.wgsl")),
        Dynamics::Inertial { density } => {
            spinning(setup, source).real("DENSITY", density).include(fragment!("dynamics/inertial.wgsl"))
        }
    };
    let radial = |f: &Force| matches!(f, Force::RadialInward { .. } | Force::RadialOutward { .. });
    let source = match setup.forces.iter().any(radial) {
        true => source.include(fragment!("dynamics/radial.wgsl")),
        false => source,
    };
    let loads = loads(setup, &source);
    source.text(&loads).include(fragment!("dynamics/motion.wgsl"))
}

/// `load_of`: the sum of the scene's forces on a body.
fn loads(setup: &Setup, source: &Source) -> String {
    let mut text =
        String::from("fn load_of(position: vec3r, shape: vec4r, group: u32) -> Load {\n    var force = vec3r();\n");
    let vector = |v: [f64; 3]| {
        let [x, y, z] = v.map(|c| source.literal(c));
        format!("vec3r({x}, {y}, {z})")
    };
    for force in &setup.forces {
        let (group, term) = match force {
            Force::Uniform { force, group } => (group, vector(*force)),
            Force::Gravity { acceleration, group } => (group, gravity(setup, &vector(*acceleration))),
            Force::RadialInward { group } => (group, "-radial(position)".to_owned()),
            Force::RadialOutward { group } => (group, "radial(position)".to_owned()),
        };
        let applies = match group {
            None => "true".to_owned(),
            Some(name) => match setup.groups.iter().position(|g| g == name) {
                Some(index) => format!("group == {index}u"),
                None => "false".to_owned(),
            },
        };
        let _ = writeln!(text, "    if {applies} {{ force += {term}; }}");
    }
    text.push_str("    return Load(force, vec3r());\n}\n");
    text
}

fn gravity(setup: &Setup, acceleration: &str) -> String {
    match setup.dynamics {
        Dynamics::Inertial { .. } => format!("DENSITY * solid(shape).volume * {acceleration}"),
        // Bodies have no mass; a scene that asks for this is refused on reading.
        Dynamics::Overdamped { .. } => "vec3r()".to_owned(),
    }
}

/// Moves the rows of an array whose elements are of this WGSL type.
pub(super) fn moved(setup: &Setup, name: &str, element: &str, per_row: u32) -> Source {
    base(setup, name)
        .text(&format!("alias Element = {element};\n"))
        .integer("PER_ROW", per_row)
        .include(fragment!("constraint/move.wgsl"))
}

/// The kernels that every scene needs.
pub(super) struct Kernels {
    pub motion: Kernel,
    pub boxes: Kernel,
    pub sweep: Kernel,
    pub inside: Kernel,
    pub store: Kernel,
    pub trial: Kernel,
    pub accept: Kernel,
    pub narrow: Vec<Kernel>,
    pub overlap: Kernel,
    pub farthest: Kernel,
    pub count: Kernel,
    pub append: Kernel,
    pub target: Kernel,
    pub move_pairs: Kernel,
    pub move_blocks: Kernel,
    pub move_reals: Kernel,
    pub incidence_count: Kernel,
    pub incidence_fill: Kernel,
    pub remember: Kernel,
    pub find: Kernel,
    pub carry: Kernel,
    /// Where bodies have inertia, in the place of `accept`.
    pub arrive: Option<Kernel>,
    /// Growth and division, where bodies grow.
    pub grow: Option<[Kernel; 2]>,
    /// Where the scene has walls.
    pub walls: Option<WallKernels>,
    /// Where steps have a middle.
    pub midpoint: Option<MidpointKernels>,
    /// Where rows are by branches.
    pub branches: Option<BranchKernels>,
}

/// The kernels of the middle of a step.
pub(super) struct MidpointKernels {
    /// Where pairs have the paper's rows.
    pub rows: Option<[Kernel; 2]>,
    /// Where bodies have inertia.
    pub middle: Option<Kernel>,
    /// Where bodies grow.
    pub stretch: Option<Kernel>,
}

/// The kernels of walls.
pub(super) struct WallKernels {
    pub find: Kernel,
    pub adjoin: Kernel,
    pub narrow: Kernel,
    pub blocks: Kernel,
}

/// All sources of a scene, in the order of [`Kernels`], the kernels of pairs and of growth last.
pub(super) fn sources(setup: &Setup) -> Vec<Source> {
    let plain = |name: &str, fragment| base(setup, name).include(fragment);
    let blocks = if setup.planar { 2 } else { 4 };
    let report = fragment!("step/report.wgsl");
    let (factor, part) = (fragment!("dynamics/factor.wgsl"), fragment!("constraint/part.wgsl"));
    let numbered = |name: &str| numbers(base(setup, name));
    let [count, append, remember] = match setup.branches {
        0 => [
            plain("count", fragment!("constraint/count.wgsl")),
            numbered("append")
                .include(factor)
                .include(part)
                .include(fragment!("constraint/row.wgsl"))
                .include(fragment!("constraint/append.wgsl")),
            plain("remember", fragment!("constraint/remember.wgsl")),
        ],
        _ => [branch_source::count(setup), branch_source::append(setup), branch_source::remember(setup)],
    };
    vec![
        motion(setup, false),
        with_bodies(setup, "box").include(fragment!("broad_phase/box.wgsl")),
        with_bodies(setup, "sweep").include(fragment!("broad_phase/sweep.wgsl")),
        base(setup, "inside").include(report).include(fragment!("broad_phase/inside.wgsl")),
        plain("store", fragment!("broad_phase/store.wgsl")),
        base(setup, "trial").include(factor).include(fragment!("dynamics/trial.wgsl")),
        plain("accept", fragment!("dynamics/accept.wgsl")),
        base(setup, "overlap").real("VIOLATING", VIOLATING).include(report).include(fragment!("step/overlap.wgsl")),
        with_bodies(setup, "farthest").include(report).include(fragment!("step/farthest.wgsl")),
        count,
        append,
        plain("target", fragment!("constraint/target.wgsl")),
        moved(setup, "move pairs", "vec2<u32>", 1),
        moved(setup, "move blocks", "vec4r", blocks),
        moved(setup, "move numbers", "real", 1),
        plain("incidence count", fragment!("constraint/incidence_count.wgsl")),
        plain("incidence fill", fragment!("constraint/incidence_fill.wgsl")),
        remember,
        numbered("find").include(fragment!("constraint/find.wgsl")),
        plain("carry", fragment!("constraint/carry.wgsl")),
    ]
}

/// The kernels of the pairs of families that the scene's shapes make.
pub(super) fn narrow_sources(setup: &Setup) -> Vec<Source> {
    let families = separation::gpu::PairFamilies::needed(setup.shapes.iter().copied());
    let source = |(k, families): (usize, separation::gpu::PairFamilies)| {
        let source = of_pairs(setup, &format!("separations {k}"));
        let near = match setup.branches {
            0 => fragment!("separation/near_boxes.wgsl"),
            _ => fragment!("separation/near_motions.wgsl"),
        };
        families.add_to(source, setup.planar).include(near).include(fragment!("separation/narrow.wgsl"))
    };
    families.into_iter().enumerate().map(source).collect()
}

/// Adds the numbers that surfaces have in the place of a second body's.
pub(super) fn numbers(source: Source) -> Source {
    source.integer("FIRST_SURFACE", FIRST_SURFACE).include(fragment!("walls/number.wgsl"))
}

/// The kernels of walls, in the order of [`WallKernels`].
pub(super) fn wall_sources(setup: &Setup) -> Option<[Source; 4]> {
    let find = separation::gpu::add_surfaces_to(numbers(with_bodies(setup, "places")), &setup.lattice);
    let narrow = separation::gpu::add_places_to(
        numbers(with_bodies(setup, "separations from surfaces")),
        &setup.lattice,
        &setup.shapes,
    );
    (!setup.walls.is_empty()).then(|| {
        [
            find.include(fragment!("walls/find.wgsl")),
            base(setup, "adjoin").include(fragment!("walls/adjoin.wgsl")),
            narrow.include(fragment!("walls/narrow.wgsl")),
            numbers(base(setup, "blocks")).include(fragment!("walls/blocks.wgsl")),
        ]
    })
}

/// The kernels of growth and division.
pub(super) fn growth_sources(setup: &Setup) -> Option<[Source; 2]> {
    setup.growth?;
    let shaped =
        |name: &str| base(setup, name).real("LENGTH_PITCH", setup.length_pitch).include(fragment!("shape/shape.wgsl"));
    Some([
        shaped("grow").include(fragment!("dynamics/grow.wgsl")),
        shaped("divide").include(fragment!("dynamics/divide.wgsl")),
    ])
}

/// The kernels of the paper's rows in the middle of a step: what they start from, and how they are tightened.
pub(super) fn midpoint_sources(setup: &Setup) -> Option<[Source; 2]> {
    let tighten =
        base(setup, "tighten").real("NEAR", NEAR).real("VIOLATING", VIOLATING).real("LEAST_ALIGNED", LEAST_ALIGNED);
    let tighten = tighten.include(fragment!("dynamics/factor.wgsl")).include(fragment!("constraint/part.wgsl"));
    (setup.midpoint && setup.branches == 0).then(|| {
        [
            base(setup, "recall").include(fragment!("constraint/recall.wgsl")),
            tighten.include(fragment!("constraint/share.wgsl")).include(fragment!("constraint/tighten.wgsl")),
        ]
    })
}

/// A source that knows how the scene's bodies turn without torque.
fn turned(setup: &Setup, name: &str) -> Source {
    spinning(setup, base(setup, name).include(fragment!("shape/shape.wgsl")))
}

/// The kernel of the motion over a step with a middle, where bodies have inertia.
pub(super) fn middle(setup: &Setup) -> Option<Source> {
    (setup.midpoint && setup.inertia()).then(|| turned(setup, "middle").include(fragment!("dynamics/middle.wgsl")))
}

/// The kernel of the velocities that a part of a step ends with, where bodies have inertia.
pub(super) fn arrive(setup: &Setup) -> Option<Source> {
    setup.inertia().then(|| turned(setup, "arrive").include(fragment!("dynamics/arrive.wgsl")))
}

/// The kernel of separations at later lengths, where bodies grow and steps have a middle.
pub(super) fn stretch(setup: &Setup) -> Option<Source> {
    let shaped = || numbers(base(setup, "stretch")).include(fragment!("shape/shape.wgsl"));
    let stretched = || shaped().include(fragment!("dynamics/stretched.wgsl"));
    let needed = setup.branches == 0 && setup.midpoint && setup.growth.is_some();
    needed.then(|| stretched().include(fragment!("dynamics/stretch.wgsl")))
}

impl Kernels {
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Self, GpuError> {
        let make = |source: &Source| Kernel::new(gpu, source);
        let mut made = Vec::new();
        for source in sources(setup) {
            made.push(make(&source)?);
        }
        let mut made = made.into_iter();
        let mut next = || made.next().ok_or_else(|| GpuError::Refused { message: "a kernel is missing".into() });
        Ok(Kernels {
            motion: next()?,
            boxes: next()?,
            sweep: next()?,
            inside: next()?,
            store: next()?,
            trial: next()?,
            accept: next()?,
            overlap: next()?,
            farthest: next()?,
            count: next()?,
            append: next()?,
            target: next()?,
            move_pairs: next()?,
            move_blocks: next()?,
            move_reals: next()?,
            incidence_count: next()?,
            incidence_fill: next()?,
            remember: next()?,
            find: next()?,
            carry: next()?,
            narrow: narrow_sources(setup).iter().map(make).collect::<Result<_, _>>()?,
            arrive: arrive(setup).as_ref().map(make).transpose()?,
            grow: match growth_sources(setup) {
                Some([grow, divide]) => Some([make(&grow)?, make(&divide)?]),
                None => None,
            },
            walls: match wall_sources(setup) {
                Some(sources) => {
                    let [find, adjoin, narrow, blocks] = &sources;
                    Some(WallKernels {
                        find: make(find)?,
                        adjoin: make(adjoin)?,
                        narrow: make(narrow)?,
                        blocks: make(blocks)?,
                    })
                }
                None => None,
            },
            branches: BranchKernels::new(gpu, setup)?,
            midpoint: match setup.midpoint {
                true => Some(MidpointKernels {
                    rows: match midpoint_sources(setup) {
                        Some([recall, tighten]) => Some([make(&recall)?, make(&tighten)?]),
                        None => None,
                    },
                    middle: middle(setup).as_ref().map(make).transpose()?,
                    stretch: stretch(setup).as_ref().map(make).transpose()?,
                }),
                false => None,
            },
        })
    }
}
