//! Why a support function is refused.

use crate::shape::ShapeError;

/// Why a support function is refused. Normals and points are in body axes.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConvexError {
    /// A point that is not finite.
    #[error("the point for the normal {normal:?} is not finite")]
    NotFinite {
        /// The normal.
        normal: [f64; 3],
    },
    /// The origin is not inside.
    #[error("the origin must be inside: along {normal:?} the body reaches {reach:e}")]
    OriginOutside {
        /// A normal.
        normal: [f64; 3],
        /// How far the point for that normal lies along it.
        reach: f64,
    },
    /// The points are not those of a convex body's normals.
    #[error(
        "no convex body has these points: along {normal:?} the point for that normal is not the farthest, the one for {farther:?} lies {by:e} farther"
    )]
    NotConvex {
        /// A normal.
        normal: [f64; 3],
        /// Another one.
        farther: [f64; 3],
        /// How much farther.
        by: f64,
    },
    /// A flat face, or a straight edge: the body is not strictly convex.
    #[error(
        "the body has a flat place at the normal {normal:?}: the point jumps by {jump:e} there, and must change steadily"
    )]
    Flat {
        /// The normal.
        normal: [f64; 3],
        /// How far.
        jump: f64,
    },
    /// A corner or a sharp edge: the body is not smooth.
    #[error("the body is not rounded at the normal {normal:?}: the same point belongs to other normals near it")]
    Sharp {
        /// The normal.
        normal: [f64; 3],
    },
    /// The centre of mass is elsewhere.
    #[error("the centre of mass must be the origin; it is at {centre:?}: take that from every point")]
    OffCentre {
        /// The centre of mass.
        centre: [f64; 3],
    },
    /// The body's axes are not its principal axes of inertia.
    #[error(
        "the body's axes must be its principal axes of inertia; the products of inertia yz, zx and xy are {products:?} of the moments' sum"
    )]
    Tilted {
        /// The products of inertia over the sum of the moments.
        products: [f64; 3],
    },
    /// A volume or an inertia of the function's own that is not the body's.
    #[error("{what} is given as {given:e}, and is {measured:e}")]
    Wrong {
        /// Which.
        what: &'static str,
        /// The function's own.
        given: f64,
        /// What the points say.
        measured: f64,
    },
    /// A size that no shape may have, or a body that is too slender or too flat.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}
