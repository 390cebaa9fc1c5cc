//! The superellipsoid `(|x / a|^n2 + |y / b|^n2)^(n1 / n2) + |z / c|^n1 <= 1`: a box with rounded edges and corners,
//! rounder for smaller exponents, an ellipsoid for 2.
//!
//! The left side to the power `1 / n1` is a norm, the gauge, so the support function is the dual norm: the same with
//! the exponents `m = n / (n - 1)` of `(a n_x, b n_y, c n_z)`. The surface point is its gradient. Volume and inertia
//! are integrals of sections, which are beta functions.
//!
//! Degenerate cases: exponents over 2 leave no curvature where the surface meets an axis: there the Hessian of the
//! support function has no bound, and is taken at `norm::LEAST_PART`.

#[cfg(feature = "gpu")]
pub(crate) mod gpu;
mod norm;

pub(crate) use norm::Norm;

use super::convex::Convex;
use super::{PLANAR_TOLERANCE, ShapeError, check_aspect, check_size, ellipsoid};
use glam::{DQuat, DVec3};
use std::collections::HashMap;
use std::fmt;
use std::sync::{LazyLock, Mutex, PoisonError};

/// The exponents that are supported. Below 1 the body is not convex; below 2 its edges or points have no radius of
/// curvature. At 10 the faces of a cube bend by 1e-4 of its size over their middle halves; at 20 the search of deep
/// overlaps missed the largest of several maxima by 4e-4 of the size in one of 60 degenerate poses, at 10 in none.
pub const EXPONENTS: [f64; 2] = [2.0, 10.0];

/// A superellipsoid's sizes, with what follows from them: made once for the same sizes and kept as long as the program
/// runs, so that it is as small as a reference, and two are equal where their sizes are.
#[derive(Clone, Copy)]
pub struct Superellipsoid(&'static Known);

struct Known {
    sizes: Sizes,
    fault: Option<ShapeError>,
    convex: Convex,
}

/// A superellipsoid as files have it: semi-axes along the body's x, y and z, and the exponents `n1` of the outline
/// through z and `n2` of the section across it, as `block n1 n2` of LAMMPS.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields, rename = "Superellipsoid"))]
struct Sizes {
    /// The three semi-axes.
    #[cfg_attr(feature = "files", schemars(extend("items" = {"type": "number", "format": "double", "exclusiveMinimum": 0})))]
    radii: [f64; 3],
    /// The exponents `[n1, n2]` of the outline through z and of the section across it, 2 to 10: 2 for an ellipse.
    #[cfg_attr(feature = "files", schemars(extend("items" = {"type": "number", "format": "double", "minimum": 2, "maximum": 10})))]
    exponents: [f64; 2],
}

static MADE: LazyLock<Mutex<HashMap<[u64; 5], &'static Known>>> = LazyLock::new(Mutex::default);

impl Superellipsoid {
    /// The superellipsoid with these semi-axes and exponents `[n1, n2]`; [`Shape::validate`](super::Shape::validate)
    /// says whether it is one.
    ///
    /// ```
    /// use relcp::shape::{Shape, Superellipsoid};
    /// let die = Shape::Superellipsoid(Superellipsoid::new([0.5; 3], [8.0; 2]));
    /// assert!(die.validate().is_ok() && die.volume() > 0.93);
    /// let star = Shape::Superellipsoid(Superellipsoid::new([0.5; 3], [0.8; 2]));
    /// assert!(star.validate().is_err());
    /// ```
    pub fn new(radii: [f64; 3], exponents: [f64; 2]) -> Superellipsoid {
        let [a, b, c] = radii.map(f64::to_bits);
        let [e, f] = exponents.map(f64::to_bits);
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        Superellipsoid(made.entry([a, b, c, e, f]).or_insert_with(|| {
            let sizes = Sizes { radii, exponents };
            let fault = validate(&sizes).err();
            // Numbers that are no shape's are never asked for.
            let norm = if fault.is_some() { Norm::new([1.0; 3], [2.0; 2]) } else { Norm::new(radii, exponents) };
            Box::leak(Box::new(Known { sizes, fault, convex: Convex::of_superellipsoid(norm) }))
        }))
    }

    /// The semi-axes.
    pub fn radii(&self) -> [f64; 3] {
        self.0.sizes.radii
    }

    /// The exponents `[n1, n2]`.
    pub fn exponents(&self) -> [f64; 2] {
        self.0.sizes.exponents
    }

    #[inline]
    pub(super) fn convex(&self) -> Convex {
        self.0.convex
    }

    pub(super) fn validate(&self) -> Result<(), ShapeError> {
        self.0.fault.map_or(Ok(()), Err)
    }

    /// The axis that it is a body of revolution about.
    pub(super) fn axis_of_revolution(&self) -> Option<DVec3> {
        let ([a, b, _], [_, n2]) = (self.radii(), self.exponents());
        (n2 == 2.0 && a == b && !self.is_ball()).then_some(DVec3::Z)
    }

    fn is_ball(&self) -> bool {
        let [a, b, c] = self.radii();
        self.exponents() == [2.0; 2] && a == b && b == c
    }

    /// Whether the plane through the origin at right angles to the z of space mirrors it.
    pub(super) fn is_planar_symmetric(&self, orientation: DQuat) -> bool {
        let axis = (orientation.inverse() * DVec3::Z).abs();
        // A coordinate plane mirrors it, whatever the exponents; others are looked for.
        let aligned = axis.to_array().iter().filter(|x| **x <= PLANAR_TOLERANCE).count() == 2;
        match self.exponents() {
            [2.0, 2.0] => ellipsoid::is_planar_symmetric(self.radii(), orientation),
            _ => aligned || self.0.convex.is_planar_symmetric(orientation),
        }
    }
}

impl PartialEq for Superellipsoid {
    fn eq(&self, other: &Superellipsoid) -> bool {
        self.0.sizes == other.0.sizes
    }
}

impl fmt::Debug for Superellipsoid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Sizes { radii, exponents } = self.0.sizes;
        f.debug_struct("Superellipsoid").field("radii", &radii).field("exponents", &exponents).finish()
    }
}

#[cfg(feature = "files")]
impl serde::Serialize for Superellipsoid {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.sizes.serialize(serializer)
    }
}

#[cfg(feature = "files")]
impl<'de> serde::Deserialize<'de> for Superellipsoid {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Sizes { radii, exponents } = Sizes::deserialize(deserializer)?;
        Ok(Superellipsoid::new(radii, exponents))
    }
}

#[cfg(feature = "files")]
impl schemars::JsonSchema for Superellipsoid {
    fn inline_schema() -> bool {
        Sizes::inline_schema()
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        Sizes::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        Sizes::json_schema(generator)
    }
}

fn validate(sizes: &Sizes) -> Result<(), ShapeError> {
    ellipsoid::validate(sizes.radii)?;
    for (name, value) in ["exponents.0", "exponents.1"].into_iter().zip(sizes.exponents) {
        check_size(name, value)?;
        if !(EXPONENTS[0]..=EXPONENTS[1]).contains(&value) {
            return Err(ShapeError::Exponent { name, value });
        }
    }
    let norm = Norm::new(sizes.radii, sizes.exponents);
    check_aspect("radii", norm.bounding_radius(), norm.half_widths().min_element())
}
