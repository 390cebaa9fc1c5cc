//! The numbers of a scene that a change during its run can set.

use super::Scene;
use super::changes::may_change;
use serde_json::Value;

/// Longer lists are not one quantity.
const LONGEST_LIST: usize = 4;
/// The most keys that are listed: more bonds or walls than these have their keys all the same.
const MOST_KEYS: usize = 400;

impl Scene {
    /// The numbers, and the short lists of numbers, that a [change](crate::scene::KeyChange) can set, by dotted keys in
    /// their order, at most 400. Keys without a value are left out.
    ///
    /// ```
    /// let scene = relcp::Scene::built_in("colony")?;
    /// let keys: Vec<String> = scene.adjustable().into_iter().map(|(key, _)| key).collect();
    /// assert!(keys.contains(&"growth.rate".into()) && keys.contains(&"time.dt".into()));
    /// assert!(!keys.contains(&"time.end".into()));
    /// # Ok::<(), relcp::Error>(())
    /// ```
    pub fn adjustable(&self) -> Vec<(String, Value)> {
        let mut full = self.with_defaults();
        (full.bodies, full.generate, full.changes) = (Vec::new(), Vec::new(), Vec::new());
        let mut found = Vec::new();
        // A scene always has a JSON form.
        collect("", &serde_json::to_value(full).unwrap_or_default(), &mut found);
        found
    }
}

fn collect(key: &str, value: &Value, found: &mut Vec<(String, Value)>) {
    if found.len() >= MOST_KEYS {
        return;
    }
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match value {
        Value::Number(_) if may_change(key) => found.push((key.into(), value.clone())),
        Value::Array(all) if is_quantity(all) && may_change(key) => found.push((key.into(), value.clone())),
        Value::Array(all) => {
            all.iter().enumerate().for_each(|(i, value)| collect(&below(&i.to_string()), value, found))
        }
        Value::Object(all) => all.iter().for_each(|(name, value)| collect(&below(name), value, found)),
        _ => {}
    }
}

fn is_quantity(all: &[Value]) -> bool {
    !all.is_empty() && all.len() <= LONGEST_LIST && all.iter().all(Value::is_number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::KeyChange;

    #[test]
    fn every_listed_key_can_be_set_to_its_own_value() {
        for name in ["colony", "compaction", "two-ellipsoids", "mother-machine", "chainmail"] {
            let mut scene = Scene::built_in(name).unwrap();
            let keys = scene.adjustable();
            assert!(keys.len() > 5, "{name}: {keys:?}");
            scene.changes = vec![KeyChange::new(scene.time.start, keys)];
            scene.validate().unwrap_or_else(|fault| panic!("{name}: {fault}"));
        }
    }

    #[test]
    fn lists_of_numbers_are_one_key_and_other_lists_have_a_key_for_each_entry() {
        let scene = Scene::built_in("two-ellipsoids").unwrap();
        let keys: Vec<String> = scene.adjustable().into_iter().map(|(key, _)| key).collect();
        assert!(keys.contains(&"forces.0.uniform.force".into()), "{keys:?}");
        assert!(!keys.iter().any(|key| key.starts_with("bodies") || key.starts_with("output")), "{keys:?}");
    }
}
