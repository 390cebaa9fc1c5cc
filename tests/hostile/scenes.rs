//! Mutated scenes, as files and by overrides.

use super::mutants::{Fate, each};
use super::text::mutate;
use relcp::scene::{Body, BuiltIn, Scene, SceneError};

/// Most bodies that a mutant is built with.
const BUILT: u64 = 200;

/// A scene that says all that can be said.
const WHOLE: &str = r#"{ "name": "whole", "seed": 7, "dynamics": { "inertial": { "density": 2.0 } },
  "time": { "dt": 0.01, "end": 1.0, "start": 0.5, "stepping": "midpoint" },
  "contact": { "method": { "multisphere": { "count": 5 } }, "overlap_tolerance": 1e-4, "max_recursions": 8, "cutoff": 0.1 },
  "solver": { "kind": "apgd", "tolerance": 1e-5, "max_iterations": 1000, "dump": { "when": "slow", "products": 9, "most": 2 } },
  "planar": false,
  "forces": [ { "uniform": { "force": [0, 0, -1], "group": "up" } }, { "gravity": { "acceleration": [0, 0, -9.8] } },
              { "radial_inward": {} }, { "radial_outward": { "group": "down" } } ],
  "growth": { "rate": 0.5, "division_length": 4.0, "reorientation_degrees": 3.0, "division_length_noise": 0.1, "rate_noise": 0.1,
              "stress_sensitivity": 0.0, "stop": { "population": 100, "time": 0.9, "radius": 50.0 } },
  "bodies": [
    { "shape": { "spherocylinder": { "diameter": 1.0, "length": 3.0 } }, "position": [9, 0, 0], "orientation": [1, 0, 0, 0], "group": "up",
      "velocity": [1, 0, 0], "angular_velocity": [0, 1, 0], "lineage": { "id": 3, "parent": 1, "birth": 0.1, "generation": 1 } },
    { "shape": { "spherocylinder": { "diameter": 1.0, "length": 2.5 } }, "position": [-9, 0, 0], "group": "down" } ],
  "generate": [ { "isotropic": { "count": 5, "shape": { "spherocylinder": { "diameter": 0.5, "length": 1.5 } }, "volume_fraction": 0.01 } },
                { "founder": { "diameter": 1.0, "length": 2.0, "group": "up" } } ],
  "output": { "every": 0.1, "step_stride": 2, "forces": true } }"#;

/// Bodies by rule, and one of each other shape.
const GENERATED: &str = r#"{ "name": "rings and drops", "time": { "dt": 0.1, "end": 1 },
  "bodies": [ { "shape": { "torus": { "major_radius": 1, "minor_radius": 0.1 } }, "position": [0, 0, 0] } ],
  "generate": [ { "chainmail": { "columns": 3, "rows": 2, "major_radius": 1.0, "minor_radius": 0.1 } } ] }"#;
const SHAPES: &str = r#"{ "name": "drops", "time": { "dt": 0.1, "end": 1 }, "contact": { "overlap_tolerance": 1e-9 },
  "bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0] },
              { "shape": { "ellipsoid": { "radii": [1, 2, 3] } }, "position": [7, 0, 0], "orientation": [1, 1, 0, 0] } ],
  "generate": [ { "isotropic": { "count": 9, "shape": { "sphere": { "radius": 0.2 } }, "volume_fraction": 0.05 } },
                { "isotropic": { "count": 4, "shape": { "ellipsoid": { "radii": [0.1, 0.2, 0.4] } }, "volume_fraction": 0.01 } } ] }"#;

const WORDS: [&str; 14] = [
    "count",
    "rows",
    "up",
    "down",
    "auto",
    "relcp",
    "snsd",
    "euler",
    "overdamped",
    "inertial",
    "dense",
    "position",
    "radius",
    "interior_point",
];

/// Reads a scene to its bodies, and tells its fault as the program would.
pub fn fate(read: Result<Scene, SceneError>) -> Fate {
    let scene = match read {
        Ok(scene) => scene,
        Err(error) => return refused(error),
    };
    if scene.body_count() > BUILT {
        return Fate::Read;
    }
    match scene.build() {
        Ok(bodies) => {
            assert_eq!(bodies.len() as u64, scene.body_count());
            let written = scene.with_defaults();
            let again = Scene::parse(&serde_json::to_string(&written).unwrap(), "again").unwrap();
            assert_eq!(again.bodies, written.bodies);
            let turned = |scene: &Scene| scene.bodies.iter().map(Body::rotation).collect::<Vec<_>>();
            assert_eq!(turned(&again), turned(&scene));
            Fate::Made
        }
        Err(error) => refused(error),
    }
}

fn refused(error: SceneError) -> Fate {
    assert!(!error.to_string().is_empty());
    assert!(!format!("{:?}", miette::Report::new(error)).is_empty());
    Fate::Refused
}

#[test]
fn mutated_scenes_are_read_or_refused() {
    let mut texts: Vec<&str> = BuiltIn::ALL.iter().map(|scene| scene.text).collect();
    texts.extend([WHOLE, GENERATED, SHAPES, WHOLE, SHAPES]);
    for text in &texts {
        Scene::parse(text, "as it is").unwrap();
    }
    let tally = each(
        (0, "scenes"),
        &texts,
        |random, text| mutate(random, text, &WORDS),
        |bytes| fate(Scene::parse(&String::from_utf8_lossy(bytes), "mutant.json")),
    );
    // The mutants go both ways: about one in twenty is a scene.
    assert!(tally.made > tally.refused / 40 && tally.refused > tally.made / 40, "{tally:?}");
}

#[test]
fn mutated_overrides_are_followed_or_refused() {
    const SETS: [&str; 10] = [
        "time={\"dt\": 0.1, \"end\": 1}",
        "seed=4",
        "bodies.0.position.1=2.5",
        "forces.0.uniform.force=[0, 0, -1]",
        "contact.method.multisphere.count=5",
        "generate.0.isotropic.count=7",
        "growth.stop.population=12",
        "dynamics.inertial.density=2",
        "bodies.2.shape.sphere.radius=1",
        "output.every=0.5",
    ];
    let tally = each(
        (4, "overrides"),
        &SETS,
        |random, set| mutate(random, set, &WORDS),
        |bytes| fate(Scene::load("two-ellipsoids", &[String::from_utf8_lossy(bytes).into_owned()])),
    );
    assert!(tally.made > 0 && tally.refused > tally.made / 20, "{tally:?}");
}
