//! Why a shape, or a proxy of it, is refused.

use super::superellipsoid::EXPONENTS;
use super::{LARGEST_SIZE, MAX_ASPECT, SMALLEST_SIZE};
use crate::digits::{exact, significant};

/// Why a shape is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// A size that is infinite or not a number.
    #[error("{name} must be finite, not {value}")]
    NotFinite {
        /// Which size.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A size that is zero or negative.
    #[error("{name} must be positive, not {}", exact(*value))]
    NotPositive {
        /// Which size.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A size whose powers leave the range of 64-bit floats.
    #[error("{name} must be at least {SMALLEST_SIZE:e} and at most {LARGEST_SIZE:e}, not {}", exact(*value))]
    OutOfRange {
        /// Which size.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A spherocylinder shorter, tip to tip, than it is wide.
    #[error("length {} is tip to tip, so it must not be less than the diameter, {}", exact(*length), exact(*diameter))]
    ShorterThanDiameter {
        /// Tip-to-tip length.
        length: f64,
        /// Diameter.
        diameter: f64,
    },
    /// A torus whose tube meets itself in the middle.
    #[error("minor_radius {} must be less than the major radius, {}", exact(*minor_radius), exact(*major_radius))]
    NoHole {
        /// Radius of the circle.
        major_radius: f64,
        /// Radius of the tube.
        minor_radius: f64,
    },
    /// An exponent with which a superellipsoid is not convex and smooth, or nearly a box.
    #[error(
        "{name} must be from {} to {}, not {}: below 1 the body is not convex, below 2 its edges have no radius of curvature",
        EXPONENTS[0], EXPONENTS[1], exact(*value)
    )]
    Exponent {
        /// Which exponent.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A shape more slender or more flat than separations are sure of.
    #[error("the largest size is {} times the smallest; at most {MAX_ASPECT} is supported", significant(*aspect, 7))]
    Aspect {
        /// The size, or the sizes, at fault.
        name: &'static str,
        /// Ratio of the largest to the smallest size.
        aspect: f64,
    },
}

impl ShapeError {
    /// The field at fault, as a key below the shape's: `radius`, `radii.1`.
    pub fn field(&self) -> &'static str {
        match *self {
            ShapeError::NotFinite { name, .. }
            | ShapeError::NotPositive { name, .. }
            | ShapeError::OutOfRange { name, .. }
            | ShapeError::Exponent { name, .. }
            | ShapeError::Aspect { name, .. } => name,
            ShapeError::ShorterThanDiameter { .. } => "length",
            ShapeError::NoHole { .. } => "minor_radius",
        }
    }
}

/// Why a shape has no proxy of so many spheres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ProxyError {
    /// An even count on a major axis: the middle sphere would be missing.
    #[error("the number of spheres on a major axis must be odd, not {count}: one is at the centre")]
    Even {
        /// The count asked for.
        count: usize,
    },
    /// Too few spheres to reach both ends, or to go round a ring without a gap.
    #[error("{count} spheres are too few: at least {least} are needed")]
    TooFew {
        /// The count asked for.
        count: usize,
        /// The least that do.
        least: usize,
    },
    /// Two equal largest radii: no line of spheres fills a disc.
    #[error("an oblate ellipsoid has no major axis to put spheres on")]
    NoMajorAxis,
    /// No line of spheres fills a rounded box.
    #[error("a superellipsoid has no multi-sphere proxy")]
    Superellipsoid,
    /// A shape of the user's own.
    #[error("a custom shape has no multi-sphere proxy")]
    Custom,
}
