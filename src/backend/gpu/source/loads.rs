//! The forces of a scene in the kernel of motions: one term per force.

use super::dragged;
use crate::backend::gpu::Setup;
use crate::dynamics::{Drag, Force, Frame, Stream, Window, along};
use crate::gpu::{Source, fragment};
use std::fmt::Write as _;

/// The distinct windows of the scene's forces. The kernel gets the share of each window in the present part.
pub(in crate::backend::gpu) fn windows(forces: &[Force]) -> Vec<Window> {
    let mut windows: Vec<Window> = Vec::new();
    for window in forces.iter().filter_map(Force::window) {
        if !windows.contains(window) {
            windows.push(*window);
        }
    }
    windows
}

/// `load_of`: the sum of the scene's forces on a body.
pub(super) fn load_of(setup: &Setup, source: &Source) -> String {
    let mut text = String::from(
        "fn load_of(position: vec3r, q: vec4r, shape: vec4r, group: u32) -> Load {\n    var force = vec3r();\n    var torque = vec3r();\n",
    );
    let windows = windows(&setup.forces);
    for force in &setup.forces {
        let (sum, term) = term(setup, source, force);
        let applies = match force.group() {
            None => "true".to_owned(),
            Some(name) => match setup.groups.iter().position(|g| g == name) {
                Some(index) => format!("group == {index}u"),
                None => "false".to_owned(),
            },
        };
        let share = match force.window().and_then(|window| windows.iter().position(|w| w == window)) {
            Some(k) => format!("parameters.shares[{}][{}] * ", k / 4, k % 4),
            None => String::new(),
        };
        let _ = writeln!(text, "    if {applies} {{ {sum} += {share}{term}; }}");
    }
    if setup.strained().is_some() {
        text.push_str("    let strained = strain_load(position, q, shape);\n");
        text.push_str("    force += strained.force;\n    torque += strained.torque;\n");
    }
    if setup.stream.is_some() {
        text.push_str("    let carried = flow_load(position, q, shape);\n");
        text.push_str("    force += carried.force;\n    torque += carried.torque;\n");
    }
    text.push_str("    return Load(force, torque);\n}\n");
    text
}

/// Adds the load of a background flow. The source already has the law's drag.
pub(super) fn flowing(stream: &Stream, drag: Option<Drag>, source: Source) -> Source {
    let source = source
        .real("FLOW_RATE", stream.rate)
        .vector("FLOW_DIRECTION", stream.direction.to_array())
        .vector("FLOW_GRADIENT", stream.gradient.to_array())
        .vector("FLOW_TURNING", stream.turning().to_array());
    dragged::of_flow(drag, with_bretherton(drag, source).include(fragment!("dynamics/flow.wgsl")))
}

/// Adds the load of the flow of a cell whose lengths change.
pub(super) fn straining(drag: Option<Drag>, source: Source) -> Source {
    let source = with_bretherton(drag, source).include(fragment!("dynamics/strain.wgsl"));
    dragged::of_strain(drag, source)
}

/// Adds Bretherton's constants: in a viscous fluid those of rods and rings of some thickness.
fn with_bretherton(drag: Option<Drag>, source: Source) -> Source {
    match drag {
        Some(Drag::Viscosity(_)) => source.include(fragment!("dynamics/bretherton_fluid.wgsl")),
        _ => source.include(fragment!("dynamics/bretherton.wgsl")),
    }
}

/// The sum to which a force contributes (`force` or `torque`), and its term.
fn term(setup: &Setup, source: &Source, force: &Force) -> (&'static str, String) {
    let vector = |v: [f64; 3]| {
        let [x, y, z] = v.map(|c| source.literal(c));
        format!("vec3r({x}, {y}, {z})")
    };
    match force {
        // A scene with one is refused on a device.
        Force::Pull { .. } => ("force", "vec3r()".to_owned()),
        Force::Uniform { force, .. } => ("force", vector(*force)),
        Force::Gravity { acceleration, .. } => ("force", gravity(setup, &vector(*acceleration))),
        Force::RadialInward { .. } => ("force", "-radial(position)".to_owned()),
        Force::RadialOutward { .. } => ("force", "radial(position)".to_owned()),
        Force::Propulsion { force, axis, .. } => {
            ("force", format!("rotate(q, {})", vector(along(*force, *axis).to_array())))
        }
        Force::Torque { torque, frame: Frame::Space, .. } => ("torque", vector(*torque)),
        Force::Torque { torque, frame: Frame::Body, .. } => ("torque", format!("rotate(q, {})", vector(*torque))),
        Force::Trap { stiffness, center, axes, .. } => {
            let strength = axes.map(|acts| if acts { -stiffness } else { 0.0 });
            let away = format!("(position - {})", vector(*center));
            ("force", format!("{} * {}", vector(strength), nearest(setup, source, &away)))
        }
    }
}

/// A difference of positions, to the nearest image along periodic axes.
fn nearest(setup: &Setup, source: &Source, away: &str) -> String {
    let lengths = setup.periods.lengths();
    if lengths.iter().all(Option::is_none) {
        return away.to_owned();
    }
    let component = |(axis, length): (&str, Option<f64>)| match length.map(|length| source.literal(length)) {
        Some(length) => format!("{away}.{axis} - {length} * floor({away}.{axis} / {length} + 0.5)"),
        None => format!("{away}.{axis}"),
    };
    let components: Vec<String> = ["x", "y", "z"].into_iter().zip(lengths).map(component).collect();
    format!("vec3r({})", components.join(", "))
}

fn gravity(setup: &Setup, acceleration: &str) -> String {
    match setup.dynamics.has_inertia() {
        true => format!("DENSITY * solid(shape).volume * {acceleration}"),
        // Without inertia bodies have no mass; validation rejects such a scene.
        false => "vec3r()".to_owned(),
    }
}
