//! The JSON of growth: one object, or a list of them, a species each.

use super::Growth;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Writes one entry as an object, several as a list. An entry with a group stands in a list, so that a scene reads as
/// it was written.
pub(crate) fn serialize<S: Serializer>(species: &[Growth], to: S) -> Result<S::Ok, S::Error> {
    match species {
        [one] if one.group.is_none() => one.serialize(to),
        several => several.serialize(to),
    }
}

/// Reads an object, a list, or null for none.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Growth>, D::Error> {
    from.deserialize_any(OneOrList)
}

struct OneOrList;

impl<'de> Visitor<'de> for OneOrList {
    type Value = Vec<Growth>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object, or a list of objects each with a `group`")
    }

    fn visit_unit<E>(self) -> Result<Self::Value, E> {
        Ok(Vec::new())
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        Growth::deserialize(MapAccessDeserializer::new(map)).map(|one| vec![one])
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(seq))
    }
}

/// The schema of it.
pub(crate) struct GrowthSchema;

impl JsonSchema for GrowthSchema {
    fn schema_name() -> Cow<'static, str> {
        "OneOrMoreGrowths".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<Growth>();
        json_schema!({ "anyOf": [one, { "type": "array", "items": one }, { "type": "null" }] })
    }
}
