//! The bending stiffness of a bond, as a scene has it: a number, `"rigid"`, or an object with axes.

/// A bending stiffness, with the directions that are straight at rest. In a scene file a number, or `"rigid"`, stands
/// for one without `axes`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Bending {
    /// The torque over the angle, in radians, by which the directions of both bodies differ; or `"rigid"`.
    #[cfg_attr(feature = "files", serde(with = "super::stiffness"), schemars(with = "super::stiffness::Stiffness"))]
    pub stiffness: f64,
    /// A direction on each body, in body axes, of any length; both point from the first body to the second, and are
    /// parallel at rest. Without it: from the first body's centre to its point, and from the second one's point to its
    /// centre.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub axes: Option<[[f64; 3]; 2]>,
}

impl Bending {
    /// A bending stiffness, torque over angle, of bodies whose points and centres lie on one line at rest.
    pub const fn new(stiffness: f64) -> Bending {
        Bending { stiffness, axes: None }
    }
}

/// The JSON of a bending stiffness.
#[cfg(feature = "files")]
pub(crate) mod json {
    use super::super::stiffness::{self, RIGID, Stiffness};
    use super::Bending;
    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
    use serde::de::value::MapAccessDeserializer;
    use serde::de::{Error, MapAccess, Unexpected, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::borrow::Cow;
    use std::fmt;

    /// Writes it, if there is one.
    pub(crate) fn serialize<S: Serializer>(bending: &Option<Bending>, to: S) -> Result<S::Ok, S::Error> {
        match bending {
            None => to.serialize_none(),
            Some(Bending { stiffness, axes: None }) => stiffness::serialize(stiffness, to),
            Some(bending) => bending.serialize(to),
        }
    }

    /// Reads it.
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Bending>, D::Error> {
        from.deserialize_any(NumberOrObject).map(Some)
    }

    struct NumberOrObject;

    impl<'de> Visitor<'de> for NumberOrObject {
        type Value = Bending;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            write!(f, "a number, \"{RIGID}\", or an object with `stiffness` and `axes`")
        }

        fn visit_f64<E>(self, stiffness: f64) -> Result<Bending, E> {
            Ok(Bending::new(stiffness))
        }

        fn visit_u64<E>(self, stiffness: u64) -> Result<Bending, E> {
            Ok(Bending::new(stiffness as f64))
        }

        fn visit_i64<E>(self, stiffness: i64) -> Result<Bending, E> {
            Ok(Bending::new(stiffness as f64))
        }

        fn visit_str<E: Error>(self, word: &str) -> Result<Bending, E> {
            let rigid = || Bending::new(f64::INFINITY);
            (word == RIGID).then(rigid).ok_or_else(|| E::invalid_value(Unexpected::Str(word), &self))
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Bending, A::Error> {
            Bending::deserialize(MapAccessDeserializer::new(map))
        }
    }

    /// The schema of a number, a word or an object.
    pub(crate) struct NumberOrBending;

    impl JsonSchema for NumberOrBending {
        fn schema_name() -> Cow<'static, str> {
            "NumberOrBending".into()
        }

        fn inline_schema() -> bool {
            true
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            let (stiffness, object) = (Stiffness::json_schema(generator), generator.subschema_for::<Bending>());
            json_schema!({ "anyOf": [stiffness, object] })
        }
    }
}
