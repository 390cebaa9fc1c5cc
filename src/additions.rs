//! What an addition costs: a kind of shape, wall, force, law, solver, measure or backend is named in few files, those
//! of the table "Where things are added" of ARCHITECTURE.md, and this test fails where another file begins to name one.

use std::fs;
use std::path::{Path, PathBuf};

/// One of each kind, and the files that may name it.
const NAMED: [(&str, &[&str]); 12] = [
    (
        "Shape::Torus",
        &[
            "shape/mod.rs",
            "shape/code.rs",
            "dynamics/drag/fluid.rs",
            "scene/validate/shapes.rs",
            "scene/generate/chainmail.rs",
        ],
    ),
    ("Shape::Superellipsoid", &["shape/mod.rs", "shape/code.rs", "dynamics/drag/fluid.rs"]),
    ("Tag::Torus", &["export/classes.rs", "shape/code.rs", "separation/gpu.rs", "render/rays.rs"]),
    (
        "Geometry::Ellipsoid",
        &[
            "shape/mod.rs",
            "shape/section.rs",
            "separation/mod.rs",
            "separation/outermost.rs",
            "scene/generate/isotropic.rs",
            "scene/generate/occupied.rs",
            "measure/axis.rs",
            "measure/interior.rs",
            "render/colour.rs",
            "render/intersect.rs",
            "render/rays.rs",
            "render/vector/outline.rs",
            "view/bodies.rs",
            "view/places.rs",
            "export/classes.rs",
            "export/gsd.rs",
            "export/vtk.rs",
        ],
    ),
    (
        "Family::Ellipsoid",
        &[
            "separation/branches.rs",
            "separation/branches/gpu.rs",
            "separation/mod.rs",
            "separation/planar.rs",
            "separation/surface.rs",
            "separation/gpu.rs",
            "separation/surface/gpu.rs",
        ],
    ),
    ("Wall::Cylinder", &["walls/wall.rs", "walls/area.rs", "walls/lines.rs", "scene/validate/walls.rs"]),
    (
        "Surface::Cylinder",
        &[
            "separation/surface.rs",
            "separation/surface/gpu.rs",
            "walls/wall.rs",
            "walls/motion.rs",
            "walls/enclosure.rs",
            "walls/space.rs",
            "scene/validate/periodic.rs",
        ],
    ),
    ("dissipation::Dissipation", &["measure/mod.rs"]),
    ("Compute::Together", &["simulation/compute.rs", "simulation/mod.rs", "run/follow.rs", "cli/processes.rs"]),
    ("Force::Gravity", &["dynamics/force.rs", "dynamics/force/field.rs", "backend/gpu/source/loads.rs"]),
    ("Dynamics::Inertial", &["dynamics/law.rs", "dynamics/thermal.rs", "backend/gpu/source.rs", "backend/gpu/heat.rs"]),
    (
        "SolverKind::Apgd",
        &["lcp/kind.rs", "lcp/engine.rs", "lcp/friction/drive.rs", "lcp/gpu/solver.rs", "lcp/gpu/layout.rs"],
    ),
];

/// All source files of a folder, without those of tests.
pub fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.ends_with("tests") || path.ends_with("tests.rs") {
            continue;
        }
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            found.push(path);
        }
    }
}

/// The code of a file, without comments and tests.
pub fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    text.lines().map(|line| line.split("//").next().unwrap()).collect::<Vec<_>>().join("\n")
}

#[test]
fn kinds_are_named_in_the_files_where_they_are_added_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut all = Vec::new();
    sources(&root, &mut all);
    all.retain(|path| !path.ends_with("additions.rs"));
    for (name, allowed) in NAMED {
        let mut naming: Vec<String> = all
            .iter()
            .filter(|path| code(path).contains(name))
            .map(|path| path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/"))
            .collect();
        naming.sort();
        let mut allowed: Vec<&str> = allowed.to_vec();
        allowed.sort_unstable();
        assert_eq!(naming, allowed, "{name}: see ARCHITECTURE.md, \"Where things are added\"");
    }
}
