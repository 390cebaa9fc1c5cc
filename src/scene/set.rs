//! Overrides `KEY=VALUE` of a scene's values, applied to its JSON before deserialization.

use super::error::{FaultKind, SceneError};
use super::place;
use super::read::Source;
use super::tree::Tree;
use serde_json::{Map, Value};
use std::sync::Arc;

/// One override.
pub(crate) struct Override {
    origin: Origin,
    key: Vec<String>,
    value: Value,
}

/// The origin of an override.
enum Origin {
    /// A text of its own, with this name.
    Alone(String),
    /// Another text, at a path of keys and indices.
    Text(Arc<Source>, Vec<String>),
}

/// Most segments of an override's key; a scene's deepest key has six.
const MAX_SEGMENTS: usize = 32;

impl Override {
    /// Reads `KEY=VALUE`. A value that does not begin like a JSON object, list or string and is not JSON is a string.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        Override::named(format!("override {text}"), text)
    }

    /// The same, with a name for faults.
    pub fn named(name: String, text: &str) -> Result<Self, SceneError> {
        let origin = Origin::Alone(name);
        let Some((dotted, value)) = text.split_once('=') else {
            let message = "expected KEY=VALUE, for example time.dt=0.01";
            return Err(origin.blame(SceneError::new(FaultKind::BadOverride, "", message)));
        };
        let mut set = Override::new(origin, dotted, Value::Null)?;
        let is_json = value.trim_start().starts_with(['{', '[', '"']);
        set.value = match set.json(dotted, value) {
            Err(fault) if is_json => return Err(fault),
            read => read.unwrap_or_else(|_| Value::String(value.to_owned())),
        };
        Ok(set)
    }

    /// An override of a dotted key by a JSON text, with a name for faults.
    #[cfg(any(test, feature = "python"))]
    pub fn of_json(name: String, dotted: &str, json: &str) -> Result<Self, SceneError> {
        let mut set = Override::new(Origin::Alone(name), dotted, Value::Null)?;
        set.value = set.json(dotted, json)?;
        Ok(set)
    }

    /// An override of a dotted key by a value, with a name for faults.
    pub fn of_value(name: String, dotted: &str, value: Value) -> Result<Self, SceneError> {
        Override::new(Origin::Alone(name), dotted, value)
    }

    fn json(&self, dotted: &str, text: &str) -> Result<Value, SceneError> {
        serde_json::from_str::<Tree>(text).map(|tree| tree.0).map_err(|fault| {
            let message = format!("the value is not JSON: {fault}");
            self.blame(SceneError::new(FaultKind::BadOverride, dotted, message))
        })
    }

    /// An override of the key `dotted` by the value at a path in a text.
    pub fn in_text(text: &Arc<Source>, path: Vec<String>, dotted: &str, value: Value) -> Result<Self, SceneError> {
        Override::new(Origin::Text(text.clone(), path), dotted, value)
    }

    fn new(origin: Origin, dotted: &str, value: Value) -> Result<Self, SceneError> {
        let refuse = |message: &str| Err(origin.blame(SceneError::new(FaultKind::BadOverride, dotted, message)));
        let key: Vec<String> = dotted.split('.').map(|s| s.trim().to_owned()).collect();
        if key.iter().any(String::is_empty) {
            return refuse("expected a dotted key without empty parts, for example bodies.0.position.1");
        }
        if key.len() > MAX_SEGMENTS {
            return refuse("the key is deeper than any key of a scene");
        }
        Ok(Override { origin, key, value })
    }

    /// Sets this override as the origin of a fault.
    pub fn blame(&self, error: SceneError) -> SceneError {
        self.origin.blame(error)
    }

    /// Whether this override set the value at `path` or a part of it.
    pub fn made(&self, path: &[String]) -> bool {
        path.starts_with(&self.key)
    }

    /// Whether `path` is a prefix of this override's key.
    pub fn passed(&self, path: &[String]) -> bool {
        !path.is_empty() && self.key.starts_with(path)
    }

    /// Puts the value into the tree, and creates missing objects on its path.
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
        self.blame(SceneError::new(FaultKind::BadOverride, key, message))
    }
}

impl Origin {
    fn blame(&self, error: SceneError) -> SceneError {
        let (text, path) = match self {
            Origin::Alone(name) => return error.of(name),
            Origin::Text(text, path) => (text, path),
        };
        let key_is_wrong = matches!(error.kind(), FaultKind::UnknownKey | FaultKind::BadOverride);
        let find = |path: &[String]| place::locate(text.text(), path);
        // An element of a list has no key of its own; the list's key is used.
        let key = || find(path)?.key.or_else(|| find(&path[..path.len().saturating_sub(1)])?.key);
        match key().filter(|_| key_is_wrong).or_else(|| Some(find(path)?.value)) {
            Some(place) => text.at(error, place),
            None => error.of(text.origin()),
        }
    }
}

/// Whether the value at this key is a choice such as `{"ellipsoid": {...}}`: another choice replaces it.
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
    fn faults_have_the_name_that_the_caller_gives() {
        let fault =
            |set: Result<Override, SceneError>| set.and_then(|set| set.apply(&mut json!({"s": 1}))).unwrap_err();
        for set in [
            Override::of_json("overrides[\"s.t\"]".into(), "s.t", "1"),
            Override::of_json("overrides[\"s.t\"]".into(), "s.t", "{"),
            Override::named("overrides[\"s.t\"]".into(), "s.t=1"),
        ] {
            let fault = fault(set);
            assert_eq!((fault.origin(), fault.key()), (Some("overrides[\"s.t\"]"), "s.t"));
            assert!(fault.to_string().starts_with("overrides[\"s.t\"]: s.t: "), "{fault}");
        }
        // A key with an equals sign in it is a key.
        assert_eq!(Override::of_json("o".into(), "a=b", "2").unwrap().key, ["a=b"]);
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
