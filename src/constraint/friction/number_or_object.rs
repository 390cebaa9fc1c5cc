//! The JSON of friction: a number for all contacts, or an object.

use super::Friction;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Writes a number where one stands for all contacts.
pub(crate) fn serialize<S: Serializer>(friction: &Friction, to: S) -> Result<S::Ok, S::Error> {
    if *friction == Friction::of_all(friction.bodies) {
        to.serialize_f64(friction.bodies)
    } else {
        friction.serialize(to)
    }
}

/// Reads a number or an object.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Friction, D::Error> {
    from.deserialize_any(NumberOrObject)
}

struct NumberOrObject;

impl<'de> Visitor<'de> for NumberOrObject {
    type Value = Friction;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, or an object with `bodies`, `walls` or `groups`")
    }

    fn visit_f64<E>(self, coefficient: f64) -> Result<Friction, E> {
        Ok(Friction::of_all(coefficient))
    }

    fn visit_u64<E>(self, coefficient: u64) -> Result<Friction, E> {
        Ok(Friction::of_all(coefficient as f64))
    }

    fn visit_i64<E>(self, coefficient: i64) -> Result<Friction, E> {
        Ok(Friction::of_all(coefficient as f64))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Friction, A::Error> {
        Friction::deserialize(MapAccessDeserializer::new(map))
    }
}

/// The schema of it.
pub(crate) struct FrictionSchema;

impl JsonSchema for FrictionSchema {
    fn schema_name() -> Cow<'static, str> {
        "NumberOrFriction".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let object = generator.subschema_for::<Friction>();
        json_schema!({ "anyOf": [{ "type": "number", "minimum": 0, "maximum": 10 }, object] })
    }
}
