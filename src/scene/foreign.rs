//! Words that users know from other programs and fields: their names in a scene, or that relcp does not have them.

/// Foreign words, and the keys with the same meaning; the first allowed key counts.
const NAMES: &[(&[&str], &[&str])] = &[
    (
        &["rod", "rods", "capsule", "cylinder", "stadium", "pill", "bacterium", "fiber", "fibre", "needle"],
        &["spherocylinder"],
    ),
    (&["ball", "disc", "disk", "circle", "point", "particle", "bead"], &["sphere"]),
    (&["spheroid", "ellipse", "oval"], &["ellipsoid"]),
    (&["superquadric", "superball", "rounded_box"], &["superellipsoid"]),
    (&["ring", "donut", "doughnut", "hoop", "loop"], &["torus"]),
    (&["plane", "floor", "ground", "halfspace", "wall"], &["half_space"]),
    (&["cuboid", "cube", "room", "container", "rectangle"], &["box"]),
    (&["tube", "pipe"], &["cylinder"]),
    (&["slit", "slab", "gap"], &["channel"]),
    (&["r", "size"], &["radius"]),
    (&["width", "thickness", "d"], &["diameter", "width"]),
    (&["height", "l", "h", "extent"], &["length"]),
    (&["semi_axes", "semiaxes", "axes", "half_axes"], &["radii"]),
    (&["r_major", "outer_radius", "ring_radius"], &["major_radius"]),
    (&["r_minor", "inner_radius", "tube_radius"], &["minor_radius"]),
    (&["pos", "center", "centre", "location", "coordinates", "xyz", "x", "origin"], &["position", "center"]),
    (&["centre", "position", "origin"], &["center"]),
    (&["min", "lower", "low"], &["minimum"]),
    (&["max", "upper", "high"], &["maximum"]),
    (&["quaternion", "quat", "rotation", "q"], &["orientation"]),
    (&["theta", "phi", "heading"], &["angle"]),
    (&["vel", "v", "speed"], &["velocity"]),
    (&["omega", "angular_speed", "w"], &["angular_velocity"]),
    (&["static", "frozen", "immobile", "kinematic"], &["fixed"]),
    (&["type", "species", "kind", "tag"], &["group"]),
    (&["number", "n", "num", "amount"], &["count"]),
    (&["fraction", "phi", "packing_fraction", "density"], &["volume_fraction"]),
    (&["timestep", "time_step", "step", "delta_t", "step_size"], &["dt"]),
    (&["duration", "t_end", "tmax", "t_max", "until", "stop", "final"], &["end"]),
    (&["begin", "t_start", "t0"], &["start"]),
    (&["integrator", "scheme", "method"], &["stepping"]),
    (&["particles", "objects", "shapes"], &["bodies"]),
    (&["wall", "boundary", "boundaries", "confinement", "container"], &["walls"]),
    (&["pbc", "periodicity", "cell", "box", "lattice"], &["periodic"]),
    (&["force", "fields", "loads", "potentials"], &["forces"]),
    (&["springs", "constraints", "links"], &["bonds"]),
    (&["tolerance", "eps", "epsilon", "overlap"], &["overlap_tolerance"]),
    (&["random_seed", "rng", "rng_seed"], &["seed"]),
    (&["two_d", "2d", "is_2d"], &["planar"]),
    (&["interval", "save_every", "period", "stride", "frequency"], &["every"]),
    (&["kt", "temp"], &["temperature"]),
    (&["brownian", "noise", "temperature", "langevin"], &["thermal"]),
    (&["viscosity", "friction", "gamma", "damping"], &["drag"]),
    (&["friction_coefficient", "mu", "coulomb", "sliding_friction", "static_friction"], &["friction"]),
    (&["bounce", "elasticity", "coefficient_of_restitution", "cor"], &["restitution"]),
    (&["k", "spring_constant", "constant"], &["stiffness"]),
    (&["g", "weight"], &["gravity", "acceleration"]),
    (&["harmonic", "spring", "tether"], &["trap"]),
    (&["active", "self_propulsion", "motility"], &["propulsion"]),
    (&["constant", "field"], &["uniform"]),
    (&["random", "fill"], &["isotropic"]),
    (&["grid", "crystal", "array"], &["lattice"]),
    (&["polymer", "filament", "necklace"], &["chain"]),
    (&["trench", "barrier", "obstacles", "polyline"], &["fence"]),
    (&["stokes", "brownian", "langevin", "viscous"], &["overdamped"]),
    (&["newton", "newtonian", "rigid_body"], &["inertial"]),
];

/// Foreign words, and the scene's key elsewhere with the same meaning.
const PLACES: &[(&[&str], &str)] = &[
    (&["dt", "timestep", "time_step"], "time.dt"),
    (&["end", "duration", "tmax", "t_end"], "time.end"),
    (&["gravity", "g"], "forces: [{ \"gravity\": { \"acceleration\": [0, 0, -9.81] } }]"),
    (&["mass", "density"], "dynamics.inertial.density"),
    (&["drag", "viscosity", "damping"], "dynamics.overdamped.drag"),
    (&["temperature", "kt"], "thermal.temperature"),
    (&["overlap_tolerance", "tolerance"], "contact.overlap_tolerance"),
    (&["every", "save_every", "output_every"], "output.every"),
    (&["restitution", "bounce", "elasticity", "coefficient_of_restitution"], "contact.restitution"),
    (&["friction", "friction_coefficient", "mu", "coulomb", "sliding_friction"], "contact.friction"),
];

/// Words for features that relcp does not have, and an explanation.
const ABSENT: &[(&[&str], &str)] = &[
    (
        &["rolling_friction", "torsional_friction", "rolling_resistance"],
        "relcp has friction of sliding only, contact.friction",
    ),
    (&["adhesion", "cohesion", "stickiness", "attraction"], "relcp has no adhesion: contacts only push"),
    (
        &["youngs_modulus", "young_modulus", "contact_stiffness", "poisson_ratio", "hertz"],
        "relcp has no stiffness of contact: bodies are rigid",
    ),
    (
        &["box", "cube", "cuboid", "block", "brick"],
        "relcp has smooth shapes only; a box with rounded edges is a `superellipsoid`",
    ),
    (
        &["mesh", "polygon", "polyhedron", "convex", "triangle"],
        "relcp has smooth shapes only; custom shapes are defined in code (docs/guide.md)",
    ),
    (&["units", "unit"], "a scene has no units: choose your own, the same for all numbers"),
];

/// The sizes of shapes.
const SIZES: [&str; 6] = ["radius", "radii", "diameter", "length", "size", "exponents"];

/// The hint for an unknown word among these allowed keys; none if no other program has the word.
pub(super) fn hint(word: &str, known: &[&str]) -> Option<String> {
    let word = word.to_lowercase().replace(['-', ' '], "_");
    let has = |words: &[&str]| words.contains(&word.as_str());
    let names = NAMES.iter().filter(|(words, _)| has(words)).flat_map(|(_, names)| *names);
    if let Some(name) = names.into_iter().find(|name| known.contains(name)) {
        return Some(format!("it is called `{name}` here"));
    }
    if let Some((_, why)) = ABSENT.iter().find(|(words, _)| has(words)) {
        return Some((*why).into());
    }
    if known.contains(&"shape") && SIZES.contains(&word.as_str()) {
        return Some("sizes are inside of the shape: \"shape\": {\"sphere\": {\"radius\": 0.5}}".into());
    }
    PLACES.iter().find(|(words, _)| has(words)).map(|(_, place)| format!("a scene has it as {place}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_other_programs_are_known() {
        let shapes = ["sphere", "spherocylinder", "ellipsoid", "torus", "superellipsoid"];
        for (word, says) in [
            ("rod", "`spherocylinder`"),
            ("Capsule", "`spherocylinder`"),
            ("ball", "`sphere`"),
            ("ring", "`torus`"),
            ("cube", "rounded edges is a `superellipsoid`"),
            ("superquadric", "called `superellipsoid`"),
            ("mesh", "defined in code"),
            ("friction", "contact.friction"),
            ("rolling_friction", "sliding only"),
            ("dt", "time.dt"),
        ] {
            assert!(hint(word, &shapes).unwrap().contains(says), "{word}");
        }
        assert_eq!(hint("cube", &["box", "sphere"]).unwrap(), "it is called `box` here");
        assert_eq!(hint("qwerty", &shapes), None);
        assert!(hint("radius", &["shape", "position"]).unwrap().contains("inside of the shape"));
        assert_eq!(hint("radius", &["diameter", "length"]), None);
    }
}
