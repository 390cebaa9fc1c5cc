//! The fragments that kernels replace where drag depends on the direction: mobilities of translation are then matrices.

use super::super::Setup;
use crate::dynamics::Drag;
use crate::dynamics::drag::fluid::{ring, rod};
use crate::gpu::{Source, fragment};

/// A text of a kernel, and the one in its place.
type Swap = (&'static str, &'static str);

const ROW: Swap = ("parameters.root_dt * free.w * normal,", "parameters.root_dt * translation_root(body, normal),");

const TRIAL: Swap =
    ("motions[first].w / parameters.root_dt * linear;", "translation_root(i, linear) / parameters.root_dt;");

const KEPT: Swap = (
    "    motions[first + 1u] = vec4r(motion.angular, motion.rotation);\n",
    "    motions[first + 1u] = vec4r(motion.angular, motion.rotation);\n    keep_translation(first, shape, q);\n",
);

/// The damping of both motions by axis.
const DAMPING: [Swap; 2] = [
    ("struct Damping { kept: real, share: real,", "struct Damping { kept: vec3r, share: vec3r,"),
    (
        "    let length = major_axis(shape);
    let a = time * DRAG * length / (DENSITY * body.volume);
    let b = time * DRAG * length * length * length / 12.0 / (DENSITY * body.inertia);
    return Damping(
        1.0 - lost(a),
        share_of(a),
",
        "    let resists = resistance_of(shape);
    let a = time * resists.linear / (DENSITY * body.volume);
    let b = time * resists.turning / (DENSITY * body.inertia);
    return Damping(
        vec3r(1.0 - lost(a.x), 1.0 - lost(a.y), 1.0 - lost(a.z)),
        vec3r(share_of(a.x), share_of(a.y), share_of(a.z)),
",
    ),
];

const DAMPED: [Swap; 3] = [
    ("part.share * time / mass * load.force;", "parts_of(q, part.share, time / mass * load.force);"),
    ("let translation = sqrt(parameters.dt / mass * whole.share);", "let translation = real(0.0);"),
    ("Motion(part.kept * velocity + speeding,", "Motion(parts_of(q, part.kept, velocity) + speeding,"),
];

/// The middle keeps what forces add after the move: it has the axes of the middle, the rest those of the start.
const MIDDLE: [Swap; 2] = [
    ("before.kept * twists[2u * i].xyz + speeding.xyz", "parts_of(q, before.kept, twists[2u * i].xyz) + speeding.xyz"),
    (
        "    motions[first + 7u] = vec4r(impulse, 0.0);\n",
        "    motions[first + 7u] = vec4r(impulse, speeding.z);
    let last = first + MOTION - 1u;
    motions[last] = vec4r(motions[last].xy, speeding.xy);\n",
    ),
];

const ARRIVE: Swap = (
    "        linear = after.kept * linear + (motions[first].xyz - after.kept * start_twists[2u * i].xyz);\n",
    "        let ended = unit_quaternion(end_orientations[2u * i], end_orientations[2u * i + 1u]);
        let speeding = vec3r(motions[first + MOTION - 1u].zw, motions[first + 7u].w);
        linear = parts_of(ended, after.kept, linear) + speeding;\n",
);

const HEAT: Swap = ("strong.x * vec3r(a, b.x)", "rotate(q, pushes(shapes[i], parameters.dt) * vec3r(a, b.x))");

const FLOW: [Swap; 2] = [
    (
        "    let length = major_axis(shape);\n    let resistance = DRAG * length;\n    var force = resistance * FLOW_RATE",
        "    let resists = resistance_of(shape);\n    var force = FLOW_RATE",
    ),
    (
        "* FLOW_DIRECTION;\n    var torque = resistance * length * length / 12.0 * turning;",
        "* FLOW_DIRECTION;\n    force = along_axes(q, resists.linear, force);\n    var torque = along_axes(q, resists.turning, turning);",
    ),
];

const STRAIN: Swap = (
    "    let length = major_axis(shape);
    let resistance = DRAG * length;
    var force = resistance * rates * position;
    var torque = resistance * length * length / 12.0 * rotate(q, bretherton(shape) * strain);
",
    "    let resists = resistance_of(shape);
    var force = along_axes(q, resists.linear, rates * position);
    var torque = rotate(q, resists.turning * bretherton(shape) * strain);
",
);

/// Replaces texts that the source has once each.
fn swapped(source: Source, swaps: &[Swap]) -> Source {
    swaps.iter().fold(source, |source, (from, to)| {
        debug_assert_eq!(source.code().matches(from).count(), 1, "{from}");
        source.mapped(|text| text.replace(from, to))
    })
}

/// Adds the resistances of a body, and what acts along its axes.
pub(super) fn resisting(source: Source, drag: Drag) -> Source {
    let source = source.include(fragment!("dynamics/axes.wgsl"));
    match drag {
        Drag::Even(xi) => source.real("DRAG", xi),
        Drag::Axes { parallel, perpendicular, rotation } => source
            .real("PARALLEL", parallel)
            .real("PERPENDICULAR", perpendicular)
            .real("ROTATION", rotation)
            .include(fragment!("dynamics/drag_axes.wgsl")),
        Drag::Viscosity(viscosity) => fluid(source.real("VISCOSITY", viscosity)),
    }
}

/// Adds the drag of a fluid: ellipsoids, and the fits of rods and rings with their numbers.
fn fluid(source: Source) -> Source {
    let ([along, across, over], [of_ring, turning, about]) = (rod::SLOWER, ring::TERMS);
    let [a, b, c] = rod::SPINNING;
    let [d, e, f, g, h] = rod::TUMBLING;
    let named = [
        ("ROD_ALONG", along),
        ("ROD_ACROSS", across),
        ("ROD_OVER", over),
        ("ROD_TUMBLING", [d, e, f, g, h, 0.0]),
        ("RING_ALONG", of_ring),
        ("RING_OVER", turning),
        ("RING_ABOUT", about),
        ("RING_ACROSS", ring::ACROSS),
        ("RING_TUMBLING", ring::TUMBLING),
    ];
    let source = named.into_iter().fold(source.vector("ROD_SPINNING", [a, b, c]), six);
    source.include(fragment!("dynamics/drag_fluid.wgsl"))
}

/// Adds six numbers as two constants.
fn six(source: Source, (name, [a, b, rest @ ..]): (&str, [f64; 6])) -> Source {
    let [a, b] = [a, b].map(|number| source.literal(number));
    let [c, d, e, f] = rest.map(|number| source.literal(number));
    let text = format!("const {name}_0: vec2r = vec2r({a}, {b});\nconst {name}: vec4r = vec4r({c}, {d}, {e}, {f});\n");
    source.text(&text)
}

/// The overdamped law.
pub(super) fn overdamped(source: Source, drag: Drag) -> Source {
    resisting(source, drag).include(fragment!("dynamics/overdamped_axes.wgsl"))
}

/// Adds the effect of drag on a motion with inertia.
pub(super) fn damping(source: Source, density: f64, drag: Drag) -> Source {
    let source = resisting(source, drag).real("DENSITY", density);
    swapped(source.include(fragment!("dynamics/damping.wgsl")), &DAMPING)
}

/// Adds the inertial law with drag to a source with its damping.
pub(super) fn damped(source: Source) -> Source {
    let source = source.include(fragment!("dynamics/damped.wgsl")).include(fragment!("dynamics/damped_roots.wgsl"));
    swapped(source, &DAMPED)
}

/// The kernel of motions, which keeps the root of each body's translational mobility.
pub(super) fn keeping(setup: &Setup, source: Source) -> Source {
    match setup.has_axes_of_drag() {
        true => swapped(source, &[KEPT]).include(fragment!("dynamics/along_kept.wgsl")),
        false => source,
    }
}

/// A kernel of rows.
pub(super) fn of_rows(setup: &Setup, source: Source) -> Source {
    of_root(setup, source, ROW)
}

/// The kernel of trials.
pub(in super::super) fn of_trial(setup: &Setup, source: Source) -> Source {
    of_root(setup, source, TRIAL)
}

fn of_root(setup: &Setup, source: Source, swap: Swap) -> Source {
    match setup.has_axes_of_drag() {
        true => swapped(source, &[swap]).include(fragment!("dynamics/along.wgsl")),
        false => source,
    }
}

/// The kernel of midpoint steps with drag and inertia.
pub(in super::super) fn of_middle(setup: &Setup, source: Source) -> Source {
    if setup.has_axes_of_drag() { swapped(source, &MIDDLE) } else { source }
}

/// The kernel of arrivals with drag and inertia.
pub(in super::super) fn of_arrival(setup: &Setup, source: Source) -> Source {
    if setup.has_axes_of_drag() { swapped(source, &[ARRIVE]) } else { source }
}

/// Adds the strength of random loads without inertia.
pub(in super::super) fn heated(source: Source, drag: Drag) -> Source {
    match drag {
        Drag::Even(xi) => source.real("DRAG", xi).include(fragment!("dynamics/heat_overdamped.wgsl")),
        drag => resisting(source, drag).include(fragment!("dynamics/heat_axes.wgsl")),
    }
}

/// The same with inertia, to a source with its damping.
pub(in super::super) fn heated_with_inertia(source: Source, drag: Drag) -> Source {
    match drag {
        Drag::Even(_) => source.include(fragment!("dynamics/heat_damped.wgsl")),
        _ => source.include(fragment!("dynamics/heat_damped_axes.wgsl")),
    }
}

/// The kernel of random loads.
pub(in super::super) fn of_heat(setup: &Setup, source: Source) -> Source {
    if setup.has_axes_of_drag() { swapped(source, &[HEAT]) } else { source }
}

/// A source with a flow's load.
pub(super) fn of_flow(drag: Option<Drag>, source: Source) -> Source {
    if drag.is_some_and(|drag| drag.even().is_none()) { swapped(source, &FLOW) } else { source }
}

/// A source with the load of a cell whose lengths change.
pub(super) fn of_strain(drag: Option<Drag>, source: Source) -> Source {
    if drag.is_some_and(|drag| drag.even().is_none()) { swapped(source, &[STRAIN]) } else { source }
}
