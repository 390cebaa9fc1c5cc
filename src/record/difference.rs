//! The keys in which two scenes differ.

use crate::scene::Scene;
use serde_json::Value;
use std::path::Path;

/// The number of keys that are listed; the others are counted.
const KEYS_NAMED: usize = 5;

/// The first keys in which a scene differs from the one in the file `recorded`.
pub fn differing_keys(recorded: &Path, scene: &Scene) -> Vec<String> {
    let mut keys = all_differing_keys(recorded, scene);
    if keys.is_empty() {
        keys.push("what its scene.json does not show".into());
    }
    if keys.len() > KEYS_NAMED {
        let more = keys.len() - KEYS_NAMED;
        keys.truncate(KEYS_NAMED);
        keys.push(format!("{more} more"));
    }
    keys
}

/// All keys in which a scene differs from the one in the file `recorded`.
pub fn all_differing_keys(recorded: &Path, scene: &Scene) -> Vec<String> {
    let read = |path: &Path| serde_json::from_slice::<Value>(&std::fs::read(path).ok()?).ok();
    let mut keys = Vec::new();
    if let (Some(old), Ok(new)) = (read(recorded), serde_json::to_value(scene.with_defaults())) {
        compare("", &old, &new, &mut keys);
    }
    keys
}

/// Collects the dotted paths of the values in which two documents differ.
fn compare(path: &str, old: &Value, new: &Value, keys: &mut Vec<String>) {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match (old, new) {
        (Value::Object(old), Value::Object(new)) => {
            let added = new.keys().filter(|key| !old.contains_key(*key));
            for key in old.keys().chain(added) {
                let at = |side: &serde_json::Map<String, Value>| side.get(key).cloned().unwrap_or(Value::Null);
                compare(&join(key), &at(old), &at(new), keys);
            }
        }
        (Value::Array(old), Value::Array(new)) if old.len() == new.len() => {
            for (i, (old, new)) in old.iter().zip(new).enumerate() {
                compare(&join(&i.to_string()), old, new, keys);
            }
        }
        _ if old != new => keys.push(path.to_owned()),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn differing_keys_are_dotted_paths() {
        let old = json!({"time": {"dt": 0.1, "end": 1.0}, "bodies": [{"x": 1}, {"x": 2}], "gone": true});
        let new = json!({"time": {"dt": 0.2, "end": 1.0}, "bodies": [{"x": 1}, {"x": 3}], "come": 1});
        let mut keys = Vec::new();
        compare("", &old, &new, &mut keys);
        keys.sort();
        assert_eq!(keys, ["bodies.1.x", "come", "gone", "time.dt"]);
    }
}
