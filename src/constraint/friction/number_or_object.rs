//! The JSON of coefficients of contact: a number for all contacts, or an object.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// Coefficients that a number can stand for.
pub(crate) trait NumberStands: Serialize + for<'de> Deserialize<'de> + JsonSchema {
    /// The name of what is a number or these.
    const EITHER: &'static str;
    /// The keys of the object.
    const KEYS: &'static str;
    /// The largest one.
    const LARGEST: u32;
    /// The same coefficient for all contacts.
    fn of_all(coefficient: f64) -> Self;
    /// The number that stands for these, if one does.
    fn number(&self) -> Option<f64>;
}

/// Writes a number where one stands for all contacts.
pub(crate) fn serialize<C: NumberStands, S: Serializer>(coefficients: &C, to: S) -> Result<S::Ok, S::Error> {
    match coefficients.number() {
        Some(number) => to.serialize_f64(number),
        None => coefficients.serialize(to),
    }
}

/// Reads a number or an object.
pub(crate) fn deserialize<'de, C: NumberStands, D: Deserializer<'de>>(from: D) -> Result<C, D::Error> {
    from.deserialize_any(NumberOrObject(PhantomData))
}

struct NumberOrObject<C>(PhantomData<C>);

impl<'de, C: NumberStands> Visitor<'de> for NumberOrObject<C> {
    type Value = C;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a number, or an object with {}", C::KEYS)
    }

    fn visit_f64<E>(self, coefficient: f64) -> Result<C, E> {
        Ok(C::of_all(coefficient))
    }

    fn visit_u64<E>(self, coefficient: u64) -> Result<C, E> {
        Ok(C::of_all(coefficient as f64))
    }

    fn visit_i64<E>(self, coefficient: i64) -> Result<C, E> {
        Ok(C::of_all(coefficient as f64))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<C, A::Error> {
        C::deserialize(MapAccessDeserializer::new(map))
    }
}

/// The schema of it.
pub(crate) struct NumberOr<C>(PhantomData<C>);

impl<C: NumberStands> JsonSchema for NumberOr<C> {
    fn schema_name() -> Cow<'static, str> {
        C::EITHER.into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let object = generator.subschema_for::<C>();
        json_schema!({ "anyOf": [{ "type": "number", "minimum": 0, "maximum": C::LARGEST }, object] })
    }
}
