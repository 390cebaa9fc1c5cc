//! Scenes: reading, refusing, building, writing.
#![allow(clippy::unwrap_used)]

#[path = "scenes/placement.rs"]
mod placement;

use proptest::prelude::*;
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::internals::dynamics::grow;
use relcp::scene::{self, FaultKind, Force, Generate, Method, Scene, SceneError};
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;

fn good() -> Scene {
    Scene::built_in("two-ellipsoids").unwrap()
}

// ---- built-in scenes ----

#[test]
fn built_in_scenes_are_read_built_and_come_back() {
    for entry in scene::BuiltIn::ALL {
        let read = Scene::parse(entry.text, entry.name).unwrap();
        assert_eq!(read.name, entry.name);
        let written = read.to_json();
        assert_eq!(Scene::parse(&written, "written").unwrap(), read, "{}", entry.name);
        assert_eq!(Scene::parse(&written, "written").unwrap().to_json(), written);
        let resolved = read.with_defaults();
        assert_eq!(Scene::parse(&resolved.to_json(), "resolved").unwrap(), resolved);
        let bodies = read.build().unwrap();
        assert_eq!(bodies.len() as u64, read.body_count());
        let states = (read.time.end - read.time.start) / read.output_every().unwrap();
        assert!(states <= 100.5, "{}: {states} states", entry.name);
    }
}

#[test]
fn the_paper_s_numbers_stand_in_the_scenes() {
    let colony = Scene::built_in("colony-full").unwrap();
    assert_eq!(colony.growth[0].division_length, Some(4.0));
    // 17 generations end at 17 ln 2.
    assert!(colony.time.end > 17.0 * std::f64::consts::LN_2 && colony.time.end < 18.0 * std::f64::consts::LN_2);
    let colony = Scene::built_in("colony").unwrap();
    assert!(colony.time.end > 9.0 * std::f64::consts::LN_2 && colony.time.end < 10.0 * std::f64::consts::LN_2);
    assert_eq!(Scene::built_in("three-capsules").unwrap().time.steps(), 8);
    assert_eq!(Scene::built_in("compaction-full").unwrap().body_count(), 10_000);
}

/// Bodies at the end of a scene's run, from its growth alone.
fn grown_to_the_end(scene: &Scene) -> Bodies {
    let (mut bodies, growth, time) = (scene.build().unwrap(), scene.growth[0].clone(), scene.time);
    let mut next_id = bodies.len() as u64;
    for step in 0..time.steps() {
        grow(&mut bodies, &growth, scene.planar, scene.seed, time.after(step), time.dt, &mut next_id);
    }
    bodies
}

#[test]
fn the_colony_ends_with_512_cells_under_either_law() {
    let colony = Scene::built_in("colony").unwrap();
    let bodies = grown_to_the_end(&colony);
    assert_eq!(bodies.len(), 512);
    assert!(bodies.lineage.iter().all(|l| l.generation == 9));
    // Nine doublings take 9 ln 2 = 6.2383; a cell divides at the start of the step after it has reached its length.
    let early = set("colony", &["time.end=6.239"]).unwrap();
    assert_eq!(grown_to_the_end(&early).len(), 256);
    let inertial = set("colony", &["dynamics.inertial.density=1"]).unwrap();
    assert_eq!(grown_to_the_end(&inertial).len(), 512);
}

#[test]
fn ids_of_parents_are_not_given_again() {
    let scene = Scene::built_in("three-capsules").unwrap();
    let mut bodies = scene.build().unwrap();
    bodies.lineage[1].parent = Some(41);
    assert_eq!(Simulation::builder(scene).bodies(bodies).build().unwrap().state().unwrap().next_id, 42);
}

// ---- refusing ----

/// One broken scene: edits of a good scene, or a text of its own, and what the refusal must say.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Broken {
    name: String,
    /// The built-in scene that the edits start from.
    #[serde(default)]
    base: String,
    /// Old and new text, each replaced once.
    #[serde(default)]
    edit: Vec<(String, String)>,
    #[serde(default)]
    text: Option<String>,
    kind: String,
    key: String,
    says: String,
    /// What stands at the place.
    #[serde(default)]
    at: Option<String>,
}

impl Broken {
    fn text(&self) -> String {
        let mut text = self.text.clone().unwrap_or_else(|| {
            scene::BuiltIn::ALL
                .iter()
                .find(|b| b.name == self.base)
                .unwrap_or_else(|| panic!("{}: no base", self.name))
                .text
                .to_owned()
        });
        for (old, new) in &self.edit {
            assert!(text.contains(old), "{}: nothing to replace: {old}", self.name);
            text = text.replacen(old, new, 1);
        }
        text
    }
}

#[test]
fn broken_scenes_are_refused_with_kind_key_place_and_message() {
    let tables = [include_str!("broken_scenes/table.json"), include_str!("broken_scenes/motion.json")];
    let table: Vec<Broken> = tables.iter().flat_map(|table| serde_json::from_str::<Vec<_>>(table).unwrap()).collect();
    assert!(table.len() >= 60);
    let mut wrong = Vec::new();
    for broken in &table {
        let text = broken.text();
        let Err(error) = Scene::parse(&text, "broken.json") else {
            wrong.push(format!("{}: accepted", broken.name));
            continue;
        };
        let (line, column) = (error.line().unwrap_or(0), error.column().unwrap_or(0));
        let there: String =
            text.lines().nth(line.saturating_sub(1)).unwrap_or("").chars().skip(column.saturating_sub(1)).collect();
        let place = broken.at.as_ref().is_none_or(|at| there.starts_with(at.as_str()));
        let right = format!("{:?}", error.kind()) == broken.kind
            && error.key() == broken.key
            && error.message().contains(&broken.says);
        if !right || line == 0 || column == 0 || !place || error.kind() == FaultKind::Io {
            wrong.push(format!("{}: {:?} {error}\n    there: {there:.40}", broken.name, error.kind()));
        }
    }
    assert!(wrong.is_empty(), "{} of {} wrong:\n{}", wrong.len(), table.len(), wrong.join("\n"));
}

#[test]
fn files_that_cannot_be_read_are_not_bad_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let missing = Scene::read(folder.path().join("none.json")).unwrap_err();
    assert_eq!(missing.kind(), FaultKind::Io);
    let directory = Scene::read(folder.path()).unwrap_err();
    assert_eq!(directory.kind(), FaultKind::Io);
    assert!(directory.to_string().contains("directory"));
    let bytes = folder.path().join("bytes.json");
    std::fs::write(&bytes, b"{\n \"name\": \"\xff\"}").unwrap();
    let error = Scene::read(&bytes).unwrap_err();
    assert_eq!((error.kind(), error.line(), error.column()), (FaultKind::Syntax, Some(2), Some(11)));
    let file = folder.path().join("scene.json");
    std::fs::write(&file, format!("\u{feff}{}", good().to_json())).unwrap();
    assert_eq!(Scene::read(&file).unwrap(), good());
    assert_eq!(Scene::read(&file).unwrap(), good());
    let misspelt = Scene::load("colny", scene::NO_OVERRIDES).unwrap_err();
    assert!(misspelt.help_text().unwrap().contains("`colony`"));
}

#[test]
fn scenes_built_in_code_are_validated_too() {
    let mut scene = good();
    scene.bodies[1].position[2] = f64::NAN;
    let error = scene.validate().unwrap_err();
    assert_eq!((error.key(), error.line()), ("bodies.1.position.2", None));
    assert_eq!(error.to_string(), "bodies.1.position.2: must be finite");
    assert_eq!(scene.build().unwrap_err().key(), "bodies.1.position.2");
    let mut scene = good();
    scene.time.dt = f64::INFINITY;
    assert_eq!(scene.validate().unwrap_err().key(), "time.dt");
}

#[test]
fn a_refusal_points_into_the_text() {
    let text = good().to_json().replace("\"dt\": 0.01", "\"dt\": -1.5");
    let error = Scene::parse(&text, "my.json").unwrap_err();
    let mut picture = String::new();
    miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none())
        .render_report(&mut picture, &error)
        .unwrap();
    assert!(picture.contains("\"dt\": -1.5") && picture.contains("my.json") && picture.contains("here"), "{picture}");
}

// ---- overrides ----

fn set(source: &str, sets: &[&str]) -> Result<Scene, SceneError> {
    Scene::load(source, sets.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>())
}

#[test]
fn overrides_reach_every_key() {
    let scene = set(
        "two-ellipsoids",
        &[
            "bodies.0.position.1=3.25",
            "bodies.0.shape.ellipsoid.radii=[1, 1, 3]",
            "forces.1.uniform.force=[0, 2, 0]",
            "forces.2.uniform.force=[0.5, 0, 0]",
            "contact.method.multisphere.count=7",
            "solver.kind=bbpgd",
            "dynamics.inertial.density=2",
            "name=sweep",
        ],
    )
    .unwrap();
    assert_eq!(scene.bodies[0].position[1], 3.25);
    assert_eq!(scene.bodies[0].shape, Shape::Ellipsoid { radii: [1.0, 1.0, 3.0] });
    assert_eq!(scene.forces[1], Force::Uniform { force: [0.0, 2.0, 0.0], group: Some("lower".into()), window: None });
    assert_eq!(scene.forces[2], Force::Uniform { force: [0.5, 0.0, 0.0], group: None, window: None });
    assert_eq!(scene.contact.method, Method::Multisphere { count: 7 });
    assert_eq!(scene.name, "sweep");
    // What was not there is made.
    assert_eq!(set("three-capsules", &["forces.0.uniform.force=[1,0,0]"]).unwrap().forces.len(), 1);
    assert_eq!(set("three-capsules", &["solver.max_iterations=5"]).unwrap().lcp_settings().max_iterations, 5);
}

#[test]
fn bad_overrides_name_themselves_and_the_nearest_key() {
    for (text, key, says) in [
        ("time.dtt=1", "time.dtt", "nearest is `dt`"),
        ("contat.method=snsd", "contat", "nearest is `contact`"),
        ("time.dt=fast", "time.dt", "expected a number"),
        ("time.dt=-1", "time.dt", "must be positive"),
        ("bodies.0.position.1=NaN", "bodies.0.position.1", "expected a number"),
        ("bodies.0.shape.elipsoid.radii=[1,1,1]", "bodies.0.shape.elipsoid", "nearest is `ellipsoid`"),
        ("bodies.9.position.1=1", "bodies.9", "index from 0 to 2"),
        ("name.x=1", "name.x", "single value"),
        ("forces.0.uniform.group=uper", "forces.0.uniform.group", "nearest group is `upper`"),
        ("solver.kind=bbpg", "solver.kind", "nearest is `bbpgd`"),
    ] {
        let error = set("two-ellipsoids", &[text]).unwrap_err();
        assert_eq!(error.key(), key, "{error}");
        assert!(error.message().contains(says), "{error}");
        assert_eq!((error.origin(), error.line()), (Some(format!("override {text}").as_str()), None), "{error}");
    }
    // A fault of the file itself stays in the file, also with overrides, and repeated keys are still seen.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.json");
    for (broken, key) in [("\"dt\": 0.01, \"dt\": 1", "time.dt"), ("\"dt\": 0", "time.dt"), ("\"tt\": 1", "time.tt")] {
        std::fs::write(&file, good().to_json().replace("\"dt\": 0.01", broken)).unwrap();
        let error = Scene::load(&file, ["output.step_stride=2"]).unwrap_err();
        assert_eq!(error.key(), key, "{error}");
        assert!(error.line() > Some(1), "{error}");
    }
}

// ---- round trips ----

#[test]
fn an_orientation_is_normalized_once() {
    let text = good().to_json().replacen("\"orientation\": [0.6532814824381883", "\"orientation\": [6.5", 1);
    let scene = Scene::parse(&text, "long").unwrap();
    let norm: f64 = scene.bodies[0].orientation.unwrap().iter().map(|x| x * x).sum();
    assert!((norm - 1.0).abs() < 1e-15);
    assert_eq!(Scene::parse(&scene.to_json(), "again").unwrap(), scene);
}

#[test]
fn a_final_scene_runs_on_from_the_same_bits() {
    let mut scene = set("two-ellipsoids", &["dynamics.inertial.density=0.7"]).unwrap();
    let mut dust = Generate::isotropic(20, Shape::Sphere { radius: 0.3 }, Some(0.1));
    if let Generate::Isotropic { group, .. } = &mut dust {
        *group = Some("dust".into());
    }
    scene.generate = vec![dust];
    let mut bodies = scene.build().unwrap();
    bodies.velocity[0] = glam::DVec3::new(0.1 + 0.2, 1.0 / 3.0, -1e-17);
    bodies.lineage[3].parent = Some(1000);
    let last = scene.final_scene(&bodies, 40.0 / 3.0);
    let again = Scene::parse(&last.to_json(), "final.json").unwrap();
    assert_eq!(again, last);
    assert_eq!(again.time.start, 40.0 / 3.0);
    let rebuilt = again.build().unwrap();
    assert_eq!(rebuilt, bodies);
    assert_eq!(again.final_scene(&rebuilt, again.time.start), again);
    // Past the end, and without inertia.
    let late = good().final_scene(&good().build().unwrap(), 50.0);
    assert_eq!((late.time.end, late.bodies[0].velocity), (50.0, None));
    late.validate().unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn numbers_come_back_to_the_same_bits(x in -1e14..1e14_f64, y in 1e-50..1.0_f64, q in prop::array::uniform4(-1.0..1.0_f64)) {
        let mut scene = good();
        scene.bodies[0].position = [x, y, -y];
        scene.contact.overlap_tolerance = 0.5;
        scene.time.dt = 1.0 + y;
        prop_assume!(q.iter().any(|v| v.abs() > 1e-3));
        scene.bodies[1].orientation = Some(q);
        let once = Scene::parse(&scene.to_json(), "once").unwrap();
        prop_assert_eq!(once.bodies[0].position, scene.bodies[0].position);
        prop_assert_eq!(once.time.dt.to_bits(), scene.time.dt.to_bits());
        prop_assert_eq!(Scene::parse(&once.to_json(), "twice").unwrap(), once);
    }

    #[test]
    fn damaged_text_never_panics(which in 0..9_usize, edits in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u8, any::<u8>()), 1..6)) {
        let mut bytes = scene::BuiltIn::ALL[which].text.as_bytes().to_vec();
        for (place, how, byte) in edits {
            if bytes.is_empty() { break }
            let at = place.index(bytes.len());
            match how {
                0 => { bytes.remove(at); }
                1 => bytes.insert(at, byte),
                2 => bytes.truncate(at),
                3 => bytes[at] = b"{}[]\",:"[usize::from(byte) % 7],
                4 => bytes[at] = b'0' + byte % 10,
                5 => { let part = bytes[at..(at + usize::from(byte)).min(bytes.len())].to_vec(); bytes.splice(at..at, part); }
                _ => bytes[at] = byte,
            }
        }
        for sets in [&[][..], &["time.dt=0.5".to_owned(), "bodies.0.position.1=2".to_owned()][..]] {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("s.json");
            std::fs::write(&file, &bytes).unwrap();
            match Scene::load(&file, sets) {
                Ok(scene) => prop_assert!(scene.validate().is_ok()),
                Err(error) => prop_assert!(error.line().is_some_and(|l| l > 0) || error.origin().is_some_and(|o| o.starts_with("override ")), "{}", error),
            }
        }
    }

    #[test]
    fn overrides_never_panic(key in "[a-z.0-9_]{0,24}", value in ".{0,12}") {
        let _ = set("two-ellipsoids", &[&format!("{key}={value}")]);
        let _ = set("two-ellipsoids", &[&format!("bodies.{key}={value}")]);
    }
}

// ---- schema ----

#[test]
fn every_key_of_the_built_in_scenes_is_in_the_schema() {
    let schema = scene::schema();
    for entry in scene::BuiltIn::ALL {
        let resolved = Scene::parse(entry.text, entry.name).unwrap().with_defaults();
        check(&serde_json::to_value(&resolved).unwrap(), &schema, &schema, entry.name);
    }
    let last = good().final_scene(&good().build().unwrap(), 1.0);
    check(&serde_json::to_value(&last).unwrap(), &schema, &schema, "final");
}

#[test]
fn the_schema_bounds_what_the_reader_bounds() {
    let schema = scene::schema();
    let ellipsoid = "bodies.0.shape.ellipsoid.radii.0";
    for (base, key, bound, at, accepted) in [
        ("colony", "time.dt", "exclusiveMinimum", "0", "0.002"),
        ("colony", "dynamics.overdamped.drag", "exclusiveMinimum", "0", "2"),
        ("colony", "dynamics.inertial.density", "exclusiveMinimum", "0", "2"),
        ("colony", "contact.overlap_tolerance", "exclusiveMinimum", "0", "0.01"),
        ("colony", "contact.cutoff", "minimum", "-0.1", "0"),
        ("colony", "contact.max_recursions", "minimum", "0", "1"),
        ("chainmail", "contact.method.multisphere.count", "minimum", "0", "99"),
        ("colony", "solver.tolerance", "exclusiveMinimum", "0", "1e-9"),
        ("colony", "solver.max_iterations", "minimum", "0", "1"),
        ("colony", "growth.rate", "minimum", "-0.1", "0"),
        ("colony", "growth.division_length", "exclusiveMinimum", "0", "1"),
        ("colony", "growth.reorientation_degrees", "minimum", "-1", "0"),
        ("colony", "growth.reorientation_degrees", "maximum", "181", "180"),
        ("compaction", "generate.0.isotropic.count", "minimum", "0", "1"),
        ("compaction", "generate.0.isotropic.volume_fraction", "exclusiveMinimum", "0", "0.01"),
        ("chainmail", "generate.0.chainmail.columns", "minimum", "0", "1"),
        ("chainmail", "generate.0.chainmail.rows", "minimum", "0", "1"),
        ("chainmail", "generate.0.chainmail.major_radius", "exclusiveMinimum", "0", "1.5"),
        ("chainmail", "generate.0.chainmail.minor_radius", "exclusiveMinimum", "0", "0.05"),
        ("colony", "generate.0.founder.diameter", "exclusiveMinimum", "0", "0.4"),
        ("colony", "generate.0.founder.length", "exclusiveMinimum", "0", "3"),
        ("colony", "output.every", "exclusiveMinimum", "0", "1"),
        ("colony", "output.step_stride", "minimum", "0", "1"),
        ("two-ellipsoids", ellipsoid, "exclusiveMinimum", "0", "1"),
        ("three-capsules", "bodies.0.shape.spherocylinder.diameter", "exclusiveMinimum", "0", "0.2"),
        ("three-capsules", "bodies.0.shape.spherocylinder.length", "exclusiveMinimum", "0", "1"),
        ("three-capsules", "bodies.0.shape.sphere.radius", "exclusiveMinimum", "0", "1"),
    ] {
        assert_eq!(set(base, &[&format!("{key}={at}")]).unwrap_err().key(), key);
        set(base, &[&format!("{key}={accepted}")]).unwrap_or_else(|error| panic!("{error}"));
        let bounds: Vec<f64> = schemas_of(key, &schema).iter().filter_map(|s| s.get(bound)?.as_f64()).collect();
        let (at, accepted): (f64, f64) = (at.parse().unwrap(), accepted.parse().unwrap());
        let admits = |value: f64| match bound {
            "minimum" => value >= bounds[0],
            "maximum" => value <= bounds[0],
            _ => value > bounds[0],
        };
        assert_eq!(bounds.len(), 1, "{key} has no one {bound} in the schema");
        assert!(admits(accepted) && !admits(at), "{key}: {bound} {bounds:?}");
    }
}

/// The schemas of the value at a dotted key.
fn schemas_of<'a>(key: &str, root: &'a Value) -> Vec<&'a Value> {
    key.split('.').fold(vec![root], |schemas, segment| {
        let mut found = Vec::new();
        for schema in schemas {
            properties(schema, root, segment, &mut found);
            if segment.parse::<usize>().is_ok() {
                found.extend(resolve(schema, root).into_iter().filter_map(|s| s.get("items")));
            }
        }
        found
    })
}

/// Every object key of `value` must be a property of `schema`, through references and alternatives.
fn check(value: &Value, schema: &Value, root: &Value, place: &str) {
    match value {
        Value::Object(object) => {
            for (key, inner) in object {
                let mut found = Vec::new();
                properties(schema, root, key, &mut found);
                assert!(!found.is_empty(), "{place}.{key} is not in the schema");
                let fits = found.iter().any(|s| std::panic::catch_unwind(|| check(inner, s, root, place)).is_ok());
                assert!(fits, "{place}.{key}");
            }
        }
        Value::Array(elements) => {
            let items = resolve(schema, root).into_iter().find_map(|s| s.get("items"));
            if let Some(items) = items {
                elements.iter().for_each(|e| check(e, items, root, place));
            } else {
                assert!(elements.iter().all(|e| !e.is_object()), "{place}: a list of objects without a schema");
            }
        }
        _ => {}
    }
}

/// The schema itself and everything that it refers to or chooses from.
fn resolve<'a>(schema: &'a Value, root: &'a Value) -> Vec<&'a Value> {
    let mut all = vec![schema];
    if let Some(reference) = schema.get("$ref").and_then(Value::as_str) {
        all.extend(root.pointer(reference.trim_start_matches('#')).into_iter().flat_map(|s| resolve(s, root)));
    }
    for choice in ["oneOf", "anyOf", "allOf"] {
        for inner in schema.get(choice).and_then(Value::as_array).into_iter().flatten() {
            all.extend(resolve(inner, root));
        }
    }
    all
}

fn properties<'a>(schema: &'a Value, root: &'a Value, key: &str, found: &mut Vec<&'a Value>) {
    found.extend(resolve(schema, root).into_iter().filter_map(|s| s.get("properties").and_then(|p| p.get(key))));
    // A map from names, as `groups`, has one schema for all of them.
    found.extend(
        resolve(schema, root).into_iter().filter_map(|s| s.get("additionalProperties").filter(|s| s.is_object())),
    );
}

// ---- bodies ----

fn isotropic(count: u64, shape: Shape, volume_fraction: f64, planar: bool) -> Scene {
    let mut scene = good();
    scene.bodies.clear();
    scene.forces.clear();
    scene.planar = planar;
    scene.generate = vec![Generate::isotropic(count, shape, Some(volume_fraction))];
    scene
}

#[test]
fn generated_bodies_depend_on_the_seed_alone() {
    let scene = isotropic(300, Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }, 0.05, false);
    let first = scene.build().unwrap();
    assert_eq!(scene.build().unwrap(), first);
    let mut other = scene;
    other.seed = 2;
    assert_ne!(other.build().unwrap().position, first.position);
    // Pinned, so that a change of the draws does not pass unseen; to 1e-9, since cube roots differ in their last bit
    // between machines.
    let last = glam::DVec3::new(-13.224147808295111, 3.557165555451909, -4.39126367394289);
    assert!(first.position[299].distance(last) < 1e-9);
}

#[test]
fn groups_are_numbered_in_order_of_first_appearance() {
    let mut scene = good();
    scene.generate = vec![Generate::Founder {
        diameter: 0.5,
        length: 2.0,
        position: [0.0; 3],
        angle: 0.0,
        count: 1,
        group: Some("cell".into()),
    }];
    scene.bodies.push(scene.bodies[0].clone());
    scene.bodies[2].group = None;
    let bodies = scene.build().unwrap();
    assert_eq!(scene.group_names(), ["upper", "lower", "cell"]);
    assert_eq!(bodies.group, [0, 1, NO_GROUP, 2]);
    let axis = bodies.orientation[3] * glam::DVec3::Z;
    assert!((axis - glam::DVec3::X).length() < 1e-15);
    assert_eq!(bodies.lineage.iter().map(|l| l.id).collect::<Vec<_>>(), [0, 1, 2, 3]);
}

fn far_apart(bodies: &Bodies, holds: impl Fn(usize, usize) -> bool) {
    for a in 0..bodies.len() {
        for b in a + 1..bodies.len() {
            assert!(holds(a, b), "bodies {a} and {b}");
        }
    }
}

/// Least distance of two segments by alternating projection from a grid of starts: independent of the placement's own
/// formula.
fn axes_distance(bodies: &Bodies, a: usize, b: usize, half: f64) -> f64 {
    let along = |i: usize| bodies.orientation[i] * glam::DVec3::Z * half;
    let (u, v, d) = (along(a), along(b), bodies.position[b] - bodies.position[a]);
    let mut least = f64::INFINITY;
    for start in -4..=4 {
        let mut t = f64::from(start) / 4.0;
        for _ in 0..200 {
            let s = ((d + t * v).dot(u) / u.length_squared()).clamp(-1.0, 1.0);
            t = ((s * u - d).dot(v) / v.length_squared()).clamp(-1.0, 1.0);
            least = least.min((d + t * v - s * u).length());
        }
    }
    least
}

#[test]
fn random_bodies_do_not_overlap() {
    let rods = isotropic(150, Shape::Spherocylinder { diameter: 0.5, length: 2.5 }, 0.12, false).build().unwrap();
    far_apart(&rods, |a, b| axes_distance(&rods, a, b, 1.0) >= 0.5 - 1e-12);
    let side = (150.0 * std::f64::consts::PI * (0.25 * 2.0 * 0.25 + 0.125 / 6.0) / 0.12_f64).cbrt();
    assert!(rods.position.iter().all(|p| p.abs().max_element() <= 0.5 * side * (1.0 + 1e-12)));
    let spheres = isotropic(400, Shape::Sphere { radius: 0.5 }, 0.25, false).build().unwrap();
    far_apart(&spheres, |a, b| spheres.position[a].distance(spheres.position[b]) >= 1.0);
    let discs = isotropic(300, Shape::Sphere { radius: 0.5 }, 0.4, true).build().unwrap();
    assert!(discs.position.iter().all(|p| p.z == 0.0));
    far_apart(&discs, |a, b| discs.position[a].distance(discs.position[b]) >= 1.0);
    // An ellipsoid by its support function: some direction must separate each near pair.
    let bodies = isotropic(150, Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }, 0.12, false).build().unwrap();
    far_apart(&bodies, |a, b| separated(&bodies, a, b, glam::DVec3::new(1.0, 1.0, 2.0)));
}

/// Whether some direction of a fine set, improved by ascent, separates two ellipsoids.
fn separated(bodies: &Bodies, a: usize, b: usize, radii: glam::DVec3) -> bool {
    let d = bodies.position[b] - bodies.position[a];
    let support = |i: usize, n: glam::DVec3| (radii * (bodies.orientation[i].inverse() * n)).length();
    let gap = |n: glam::DVec3| n.dot(d) - support(a, n) - support(b, n);
    let mut best = d.normalize();
    for step in [0.3, 0.1, 0.03, 0.01, 0.003, 0.001] {
        for _ in 0..200 {
            if gap(best) > 0.0 {
                return true;
            }
            let moves = [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z]
                .map(|e| [(best + step * e).normalize(), (best - step * e).normalize()]);
            let next = moves.into_iter().flatten().fold(best, |m, n| if gap(n) > gap(m) { n } else { m });
            if next == best {
                break;
            }
            best = next;
        }
    }
    gap(best) > 0.0
}

#[test]
fn rotations_are_isotropic() {
    let bodies = isotropic(4000, Shape::Sphere { radius: 0.1 }, 0.001, false).build().unwrap();
    for body_axis in glam::DVec3::AXES {
        for axis in glam::DVec3::AXES {
            let cosines: Vec<f64> = bodies.orientation.iter().map(|q| (*q * body_axis).dot(axis)).collect();
            let mean = cosines.iter().sum::<f64>() / 4000.0;
            let square = cosines.iter().map(|c| c * c).sum::<f64>() / 4000.0;
            // Five standard errors of a uniform cosine: sqrt(1/3 / 4000) and sqrt(4/45 / 4000).
            assert!(mean.abs() < 5.0 * 0.00913 && (square - 1.0 / 3.0).abs() < 5.0 * 0.00471, "{mean} {square}");
        }
    }
}

#[test]
fn generated_bodies_keep_clear_of_given_ones() {
    let mut scene = isotropic(500, Shape::Sphere { radius: 0.5 }, 0.05, false);
    let big = r#"{"name":"b","time":{"dt":1,"end":1},"bodies":[{"shape":{"sphere":{"radius":4}},"position":[1,0,0]}]}"#;
    scene.bodies = Scene::parse(big, "big").unwrap().bodies;
    let bodies = scene.build().unwrap();
    assert!(bodies.position[1..].iter().all(|p| p.distance(glam::DVec3::X) >= 4.5));
}

#[test]
fn a_full_cube_is_refused_not_waited_for() {
    let mut scene = isotropic(10, Shape::Sphere { radius: 0.5 }, 0.1, false);
    let big =
        r#"{"name":"b","time":{"dt":1,"end":1},"bodies":[{"shape":{"sphere":{"radius":40}},"position":[0,0,0]}]}"#;
    scene.bodies = Scene::parse(big, "big").unwrap().bodies;
    let error = scene.build().unwrap_err();
    assert_eq!((error.kind(), error.key()), (FaultKind::Placement, "generate.0.isotropic.volume_fraction"));
}

// ---- rings ----

fn ring_point(bodies: &Bodies, i: usize, angle: f64) -> glam::DVec3 {
    bodies.position[i] + bodies.orientation[i] * glam::DVec3::new(angle.cos(), angle.sin(), 0.0)
}

const RING_SAMPLES: usize = 720;

/// Least distance of two unit circles: samples of one, the nearest point of the other in closed form.
fn circle_distance(bodies: &Bodies, a: usize, b: usize) -> f64 {
    let nearest = |k: usize| {
        let point = ring_point(bodies, a, k as f64 * std::f64::consts::TAU / RING_SAMPLES as f64);
        let local = bodies.orientation[b].inverse() * (point - bodies.position[b]);
        (local.truncate().length() - 1.0).hypot(local.z)
    };
    (0..RING_SAMPLES).map(nearest).fold(f64::INFINITY, f64::min)
}

/// Linking number of two circles by Gauss's integral.
fn linking_number(bodies: &Bodies, a: usize, b: usize) -> f64 {
    const N: usize = 200;
    let h = std::f64::consts::TAU / N as f64;
    let mut sum = 0.0;
    for i in 0..N {
        let (p, dp) = (
            ring_point(bodies, a, i as f64 * h),
            bodies.orientation[a] * glam::DVec3::new(-(i as f64 * h).sin(), (i as f64 * h).cos(), 0.0),
        );
        for j in 0..N {
            let dq = bodies.orientation[b] * glam::DVec3::new(-(j as f64 * h).sin(), (j as f64 * h).cos(), 0.0);
            let r = p - ring_point(bodies, b, j as f64 * h);
            sum += r.dot(dp.cross(dq)) / r.length().powi(3);
        }
    }
    sum * h * h / (4.0 * std::f64::consts::PI)
}

#[test]
fn chainmail_links_each_ring_with_its_four_neighbours_and_nothing_overlaps() {
    let mut scene = Scene::built_in("chainmail").unwrap();
    scene.generate =
        vec![Generate::Chainmail { columns: 4, rows: 3, major_radius: 1.0, minor_radius: 0.1, group: None }];
    let bodies = scene.build().unwrap();
    let mut least = f64::INFINITY;
    for a in 0..12 {
        for b in a + 1..12 {
            least = least.min(circle_distance(&bodies, a, b));
            let lattice = (a % 4).abs_diff(b % 4) + (a / 4).abs_diff(b / 4);
            let linked = linking_number(&bodies, a, b);
            let right = if lattice == 1 { 1.0 } else { 0.0 };
            assert!((linked.abs() - right).abs() < 1e-6, "rings {a} and {b}: {linked}");
        }
    }
    // Sampling is within pi / 720 of an angle, so within 1e-5 of the least distance.
    assert!((least - 0.262742).abs() < 1e-4, "{least}");
    // The thickest tube that the scene accepts leaves a clear gap, the next one is refused.
    assert!(least - 2.0 * 0.12 > 0.02);
    scene.generate =
        vec![Generate::Chainmail { columns: 2, rows: 2, major_radius: 2.0, minor_radius: 0.2401, group: None }];
    assert_eq!(scene.validate().unwrap_err().key(), "generate.0.chainmail.minor_radius");
}

#[test]
fn absurd_counts_are_refused_at_once() {
    let count = |n: u64| isotropic(n, Shape::Sphere { radius: 1.0 }, 0.01, false).validate().unwrap_err();
    for n in [1_000_000_000, 1_000_000_000_000, u64::MAX] {
        assert_eq!((count(n).kind(), count(n).key()), (FaultKind::TooLarge, "generate.0.isotropic.count"));
    }
    let mut scene = good();
    scene.generate = vec![Generate::Chainmail {
        columns: u64::MAX,
        rows: u64::MAX,
        major_radius: 1.0,
        minor_radius: 0.1,
        group: None,
    }];
    assert_eq!(scene.validate().unwrap_err().kind(), FaultKind::TooLarge);
    let error = Scene::read(Path::new("/nonexistent/x.json")).unwrap_err();
    assert_eq!(error.kind(), FaultKind::Io);
}

#[test]
fn deep_nesting_is_refused_not_followed() {
    for text in ["[".repeat(100_000), "{\"a\":".repeat(100_000), format!("{{\"name\": {}1", "[".repeat(500))] {
        let error = Scene::parse(&text, "deep").unwrap_err();
        assert_eq!((error.kind(), error.line()), (FaultKind::Syntax, Some(1)));
        assert!(error.message().contains("recursion limit"), "{}", error.message());
    }
    let error = set("colony", &[&format!("name={}", "[".repeat(100_000))]).unwrap_err();
    assert_eq!(error.kind(), FaultKind::BadOverride);
}

#[test]
fn comments_and_trailing_commas_are_read_and_faults_keep_their_places() {
    let text = "{\n  // a ball\n  \"name\": \"ball\", /* in\n space */ \"time\": { \"dt\": 0.1, \"end\": 1, },\n  # one body\n  \"bodies\": [{ \"shape\": { \"sphere\": { \"radius\": 1, }, }, \"position\": [0, 0, 0,], }],\n}\n";
    assert_eq!(Scene::parse(text, "ball.json").unwrap().time.end, 1.0);
    let error = Scene::parse(&text.replace("0.1", "-0.1"), "ball.json").unwrap_err();
    assert_eq!((error.key(), error.line(), error.column()), ("time.dt", Some(4), Some(27)));
    let shown = format!("{:?}", miette::Report::new(error));
    assert!(shown.contains("space */") && shown.contains("# one body"), "{shown}");
    let error = Scene::parse("{ \"name\": \"x\" /* no end", "x.json").unwrap_err();
    assert_eq!(error.kind(), FaultKind::Syntax);
}
