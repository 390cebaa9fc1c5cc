//! The JSON of a stiffness: a number, or `"rigid"`, which is an infinite one.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserializer, Serializer};
use std::borrow::Cow;
use std::fmt;

pub(super) const RIGID: &str = "rigid";

/// Writes it.
pub(crate) fn serialize<S: Serializer>(stiffness: &f64, to: S) -> Result<S::Ok, S::Error> {
    if stiffness.is_infinite() { to.serialize_str(RIGID) } else { to.serialize_f64(*stiffness) }
}

/// Reads it.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    from.deserialize_any(NumberOrRigid)
}

struct NumberOrRigid;

impl Visitor<'_> for NumberOrRigid {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a number, or \"{RIGID}\"")
    }

    fn visit_f64<E>(self, stiffness: f64) -> Result<f64, E> {
        Ok(stiffness)
    }

    fn visit_u64<E>(self, stiffness: u64) -> Result<f64, E> {
        Ok(stiffness as f64)
    }

    fn visit_i64<E>(self, stiffness: i64) -> Result<f64, E> {
        Ok(stiffness as f64)
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<f64, E> {
        if word == RIGID { Ok(f64::INFINITY) } else { Err(E::invalid_value(serde::de::Unexpected::Str(word), &self)) }
    }
}

/// The schema of it.
pub(crate) struct Stiffness;

impl JsonSchema for Stiffness {
    fn schema_name() -> Cow<'static, str> {
        "Stiffness".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "type": "number", "exclusiveMinimum": 0 }, { "const": RIGID }] })
    }
}

/// The JSON of a stiffness that may be left out.
pub(crate) mod optional {
    use serde::{Deserializer, Serializer};

    /// Writes it, if there is one.
    pub(crate) fn serialize<S: Serializer>(stiffness: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
        match stiffness {
            Some(stiffness) => super::serialize(stiffness, to),
            None => to.serialize_none(),
        }
    }

    /// Reads it.
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
        super::deserialize(from).map(Some)
    }
}
