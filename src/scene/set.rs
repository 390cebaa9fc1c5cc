//! Overrides `KEY=VALUE` of a scene's values, applied to its JSON before it is typed.

use super::error::{FaultKind, SceneError};
use super::tree::Tree;
use serde_json::{Map, Value};

/// One override.
pub(super) struct Override {
    text: String,
    key: Vec<String>,
    value: Value,
}

/// Most segments of an override's key; a scene's deepest key has six.
const MAX_SEGMENTS: usize = 32;

impl Override {
    /// Reads `KEY=VALUE`. A value that does not begin like a JSON object, list or string and is not JSON is a string.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let refuse = |key: &str, message: &str| {
            Err(SceneError::new(FaultKind::BadOverride, key, message).of(&format!("--set {text}")))
        };
        let Some((dotted, value)) = text.split_once('=') else {
            return refuse("", "expected KEY=VALUE, for example time.dt=0.01");
        };
        let key: Vec<String> = dotted.split('.').map(|s| s.trim().to_owned()).collect();
        if key.iter().any(String::is_empty) {
            return refuse(dotted, "expected a dotted key without empty parts, for example bodies.0.position.1");
        }
        if key.len() > MAX_SEGMENTS {
            return refuse(dotted, "the key is deeper than any key of a scene");
        }
        let value = match serde_json::from_str::<Tree>(value) {
            Ok(tree) => tree.0,
            Err(e) if value.trim_start().starts_with(['{', '[', '"']) => {
                return refuse(dotted, &format!("the value is not JSON: {e}"));
            }
            Err(_) => Value::String(value.to_owned()),
        };
        Ok(Override { text: text.to_owned(), key, value })
    }

    /// What stands before the colon of a message about this override.
    pub fn origin(&self) -> String {
        format!("--set {}", self.text)
    }

    /// Whether the value at `path` is this override's, whole or in part.
    pub fn made(&self, path: &[String]) -> bool {
        path.starts_with(&self.key)
    }

    /// Whether `path` lies on this override's way.
    pub fn passed(&self, path: &[String]) -> bool {
        !path.is_empty() && self.key.starts_with(path)
    }

    /// Puts the value into the tree, making what is missing on its way.
    pub fn apply(&self, root: &mut Value) -> Result<(), SceneError> {
        let mut here = root;
        for (depth, segment) in self.key.iter().enumerate() {
            here = self.enter(here, depth, segment)?;
        }
        *here = self.value.clone();
        Ok(())
    }

    fn enter<'v>(&self, here: &'v mut Value, depth: usize, segment: &str) -> Result<&'v mut Value, SceneError> {
        let index = segment.parse::<usize>().ok();
        let choice = is_choice(&self.key[..depth]);
        if here.is_null() {
            *here = if index.is_some() { Value::Array(Vec::new()) } else { Value::Object(Map::new()) };
        } else if choice && here.get(segment).is_none() {
            *here = Value::Object(Map::new());
        }
        match here {
            Value::Object(object) => Ok(object.entry(segment).or_insert(Value::Null)),
            Value::Array(elements) => {
                let length = elements.len();
                let Some(index) = index.filter(|&i| i <= length) else {
                    return Err(self.refuse(depth, &format!("expected an index from 0 to {length} (which appends)")));
                };
                if index == length {
                    elements.push(Value::Null);
                }
                Ok(&mut elements[index])
            }
            other => Err(self.refuse(depth, &format!("`{other}` is a single value, with no keys in it"))),
        }
    }

    fn refuse(&self, depth: usize, message: &str) -> SceneError {
        let key = self.key[..=depth].join(".");
        SceneError::new(FaultKind::BadOverride, key, message).of(&self.origin())
    }
}

/// Whether the value at this key is a choice of one of several, `{"ellipsoid": {...}}`: choosing another replaces the first.
fn is_choice(key: &[String]) -> bool {
    let key: Vec<&str> = key.iter().map(String::as_str).collect();
    matches!(key.as_slice(), ["dynamics"] | ["contact", "method"] | ["forces" | "generate", _] | [.., "shape"])
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn apply(mut tree: Value, set: &str) -> Result<Value, SceneError> {
        Override::parse(set)?.apply(&mut tree)?;
        Ok(tree)
    }

    #[test]
    fn values_are_replaced_appended_and_made() {
        assert_eq!(apply(json!({"a": {"b": [1, 2]}}), "a.b.1=2.5").unwrap(), json!({"a": {"b": [1, 2.5]}}));
        assert_eq!(apply(json!({"a": [1]}), "a.1=[3]").unwrap(), json!({"a": [1, [3]]}));
        assert_eq!(
            apply(json!({}), "forces.0.uniform.group=up").unwrap(),
            json!({"forces": [{"uniform": {"group": "up"}}]})
        );
        assert_eq!(apply(json!({"x": 1}), "x=1e999").unwrap(), json!({"x": "1e999"}));
    }

    #[test]
    fn another_choice_replaces_the_first() {
        let scene = json!({"dynamics": {"overdamped": {"drag": 1}}, "contact": {"method": "relcp"}});
        let scene = apply(scene, "dynamics.inertial.density=2").unwrap();
        let scene = apply(scene, "contact.method.multisphere.count=5").unwrap();
        let right =
            json!({"dynamics": {"inertial": {"density": 2}}, "contact": {"method": {"multisphere": {"count": 5}}}});
        assert_eq!(scene, right);
    }

    #[test]
    fn what_cannot_be_followed_is_refused() {
        for set in ["a", "=1", "a..b=1", "a.b={", "a.b=\"x", "s.t=1", "l.5=1", "l.x=1"] {
            let error = apply(json!({"s": 1, "l": [0]}), set).unwrap_err();
            assert_eq!(error.kind(), FaultKind::BadOverride, "{set}");
            assert!(error.origin().unwrap().contains(set));
        }
    }
}
