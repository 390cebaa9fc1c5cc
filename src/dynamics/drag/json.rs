//! The JSON of drag: a number, or an object.

use super::Drag;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Drag that depends on the direction: `parallel` and `perpendicular`, with or without `rotation`, or `viscosity`
/// alone. The axis of a body is its z, that of rods and rings.
#[derive(Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename = "BodyDrag", deny_unknown_fields, default)]
struct Keys {
    /// Resistance to motion along the axis, over the body's largest extent `L`: `F = parallel L u`. In the units of a
    /// number `drag`. A sphere has no axis, and has the mean `(parallel + 2 perpendicular) / 3`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    parallel: Option<f64>,
    /// Resistance to motion across the axis, over `L`: `F = perpendicular L u`. Twice `parallel` for a long thin rod.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    perpendicular: Option<f64>,
    /// Resistance to turning about any axis, `T = rotation L^3 / 12 w`. Without it: `perpendicular`, which is that of a
    /// thin rod whose pieces have that drag each.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    rotation: Option<f64>,
    /// The viscosity of a fluid, in force times time over length squared. Resistances are those of Stokes flow about
    /// the body alone: exact for spheres (`6 pi eta r`, `8 pi eta r^3`) and ellipsoids, within 0.1 % for
    /// spherocylinders and tori.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    viscosity: Option<f64>,
}

impl Keys {
    fn drag(&self) -> Result<Drag, &'static str> {
        match (self.viscosity, self.parallel, self.perpendicular, self.rotation) {
            (Some(viscosity), None, None, None) => Ok(Drag::Viscosity(viscosity)),
            (Some(_), ..) => Err("`viscosity` determines the whole drag: omit the other keys"),
            (None, Some(parallel), Some(perpendicular), rotation) => {
                Ok(Drag::Axes { parallel, perpendicular, rotation: rotation.unwrap_or(perpendicular) })
            }
            _ => Err("needs `parallel` and `perpendicular`, or `viscosity`"),
        }
    }
}

impl Serialize for Drag {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match *self {
            Drag::Even(xi) => to.serialize_f64(xi),
            Drag::Axes { parallel, perpendicular, rotation } => {
                let [parallel, perpendicular, rotation] = [parallel, perpendicular, rotation].map(Some);
                Keys { parallel, perpendicular, rotation, viscosity: None }.serialize(to)
            }
            Drag::Viscosity(viscosity) => Keys { viscosity: Some(viscosity), ..Keys::default() }.serialize(to),
        }
    }
}

impl<'de> Deserialize<'de> for Drag {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(NumberOrKeys)
    }
}

struct NumberOrKeys;

impl<'de> Visitor<'de> for NumberOrKeys {
    type Value = Drag;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, or an object with `parallel`, `perpendicular` and `rotation`, or with `viscosity`")
    }

    fn visit_f64<E>(self, xi: f64) -> Result<Drag, E> {
        Ok(Drag::Even(xi))
    }

    fn visit_u64<E>(self, xi: u64) -> Result<Drag, E> {
        Ok(Drag::Even(xi as f64))
    }

    fn visit_i64<E>(self, xi: i64) -> Result<Drag, E> {
        Ok(Drag::Even(xi as f64))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Drag, A::Error> {
        Keys::deserialize(MapAccessDeserializer::new(map))?.drag().map_err(A::Error::custom)
    }
}

impl JsonSchema for Drag {
    fn schema_name() -> Cow<'static, str> {
        "Drag".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let object = generator.subschema_for::<Keys>();
        // The bound is of numbers: it is beside the alternatives for readers that do not look into them.
        json_schema!({ "exclusiveMinimum": 0, "anyOf": [{ "type": "number", "exclusiveMinimum": 0 }, object] })
    }
}
