//! The schema has every key and the bounds of the reader.

use super::{good, set};
use relcp::scene::{self, Scene};
use serde_json::Value;

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
