//! A strictly convex shape of one's own, given by its support function's gradient: for each outward normal the surface
//! point that has it.
//!
//! [`Convex::new`] looks at the function in a few ten thousand normals: it refuses what is no smooth, strictly convex
//! body about the origin, and measures once what a simulation asks of a shape. See `sample` for what is looked at, and
//! `moments` for volume and inertia.

mod error;
mod moments;
mod sample;

pub use error::ConvexError;

use super::superellipsoid::Norm;
use super::{PLANAR_TOLERANCE, check_aspect, check_size};
use glam::{DMat3, DQuat, DVec3};
use sample::Samples;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// A smooth, strictly convex body that holds the origin: its centre of mass, with the body's axes as principal axes of
/// inertia.
///
/// A closure from the normal to the point is one. Where `h` is the support function, the point is its gradient; `h(n) =
/// n . y(n)`, so that nothing else is needed. Sums of such functions are bodies too (Minkowski sums), which makes
/// rounded ones easily: ellipsoids' points `M M^T n / |M^T n|` added up, say. Where a body has no curvature at a point,
/// as a superellipsoid on its axes, contact points near it are known to the root of rounding that the point changes
/// with there, separations as elsewhere.
pub trait SupportFunction: Send + Sync {
    /// The surface point whose outward normal is the unit vector `n`, both in body axes. The same `n` must always give
    /// the same point.
    fn point(&self, n: DVec3) -> DVec3;

    /// The volume, where it is known better than [`Convex::new`] measures it.
    fn volume(&self) -> Option<f64> {
        None
    }

    /// The moments of inertia about the body's axes per unit density, where they are known better than [`Convex::new`]
    /// measures them.
    fn unit_inertia(&self) -> Option<DVec3> {
        None
    }
}

impl<F: Fn(DVec3) -> DVec3 + Send + Sync> SupportFunction for F {
    fn point(&self, n: DVec3) -> DVec3 {
        self(n)
    }
}

/// A custom shape that has been looked at: the handle that [`Shape::Convex`](super::Shape::Convex) holds. It is as
/// small as a reference, and two are equal where they come from one call of [`Convex::new`].
#[derive(Clone, Copy)]
pub struct Convex(&'static Measured);

/// What is known of a shape.
struct Measured {
    function: Function,
    id: u64,
    bounding_radius: f64,
    thickness: f64,
    volume: f64,
    unit_inertia: DVec3,
    roundness: f64,
}

/// Where a shape's points come from.
enum Function {
    /// A user's own code; curvatures are differences over the angle `step`.
    Given { function: Box<dyn SupportFunction>, step: f64 },
    /// A closed form.
    Superellipsoid(Norm),
}

static NEXT_ID: AtomicU64 = AtomicU64::new(0);

impl Convex {
    /// Looks at a support function and keeps it.
    ///
    /// The function, and the numbers that are measured, are kept as long as the program runs, so that a shape stays a
    /// plain value: make a shape once, not once a body.
    ///
    /// # Errors
    /// A [`ConvexError`] where the function is seen to be none of a smooth, strictly convex body about its centre of
    /// mass. What lies between the normals looked at is not seen.
    ///
    /// ```
    /// use glam::DVec3;
    /// use relcp::shape::{Convex, ConvexError, Shape};
    /// // A rounded die: three needles along the axes, added up.
    /// let needle = |radii: DVec3, n: DVec3| radii * radii * n / (radii * n).length();
    /// let die = Convex::new(move |n: DVec3| DVec3::AXES.map(|axis| needle(0.1 + 0.9 * axis, n)).into_iter().sum())?;
    /// let shape = Shape::Convex(die);
    /// assert!((shape.thickness() - 2.4).abs() < 1e-12 && shape.volume() > 11.0);
    ///
    /// let displaced = Convex::new(|n: DVec3| n + 0.5 * DVec3::X);
    /// assert!(matches!(displaced, Err(ConvexError::OffCentre { .. })));
    /// # Ok::<(), ConvexError>(())
    /// ```
    pub fn new(function: impl SupportFunction + 'static) -> Result<Convex, ConvexError> {
        let mut samples = Samples::of(&function)?;
        samples.check(&function)?;
        let bounding_radius = samples.bounding_radius(&function);
        let thickness = samples.thickness();
        check_size("the bounding radius", bounding_radius)?;
        check_size("the thickness", thickness)?;
        check_aspect("point", 2.0 * bounding_radius, thickness)?;
        let (volume, unit_inertia) = samples.moments(&function, bounding_radius)?;
        let measured = Measured {
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            bounding_radius,
            thickness,
            volume,
            unit_inertia,
            roundness: samples.roundness(),
            function: Function::Given {
                function: Box::new(function),
                step: sample::curvature_step(2.0 * bounding_radius / thickness),
            },
        };
        Ok(Convex(Box::leak(Box::new(measured))))
    }

    /// A superellipsoid, of which all is known in closed form but the least radius of curvature.
    pub(super) fn of_superellipsoid(norm: Norm) -> Convex {
        let least_radius = |n: DVec3| {
            let (h11, h12, h22) = norm.hessian(n, n.any_orthonormal_pair());
            let largest = 0.5 * (h11 + h22) + (0.5 * (h11 - h22)).hypot(h12);
            (h11 * h22 - h12 * h12) / largest
        };
        // A slender body's edges are most curved at normals between those of evenly spread points and even ones. All
        // octants are alike.
        let normals = [0.0, 0.5, 1.0].into_iter().flat_map(|stretch| {
            let widths = norm.half_widths().powf(stretch);
            sample::directions(ROUNDNESS_FREQUENCY, widths).filter(|n| n.min_element() >= 0.0)
        });
        let measured = Measured {
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            bounding_radius: norm.bounding_radius(),
            thickness: norm.thickness(),
            volume: norm.volume(),
            unit_inertia: norm.unit_inertia(),
            roundness: 0.5 * normals.map(least_radius).fold(f64::INFINITY, f64::min).max(0.0),
            function: Function::Superellipsoid(norm),
        };
        Convex(Box::leak(Box::new(measured)))
    }

    /// The surface point whose outward normal is the unit vector `n`, in body axes.
    #[inline]
    pub fn point(&self, n: DVec3) -> DVec3 {
        match &self.0.function {
            Function::Given { function, .. } => function.point(n),
            Function::Superellipsoid(norm) => norm.point(n),
        }
    }

    /// The support function at the unit vector `n`: how far the body reaches along it.
    #[inline]
    pub fn reach(&self, n: DVec3) -> f64 {
        n.dot(self.point(n))
    }

    /// The Hessian of the support function across `n` in a tangent basis, as (11, 12, 22).
    #[inline]
    pub(crate) fn hessian(&self, n: DVec3, basis: (DVec3, DVec3)) -> (f64, f64, f64) {
        match &self.0.function {
            Function::Given { function, step } => sample::hessian(&**function, n, basis, *step),
            Function::Superellipsoid(norm) => norm.hessian(n, basis),
        }
    }

    /// The norm of a superellipsoid.
    #[inline]
    pub(crate) fn norm(&self) -> Option<&'static Norm> {
        match &self.0.function {
            Function::Given { .. } => None,
            Function::Superellipsoid(norm) => Some(norm),
        }
    }

    /// A number that no other shape of this program has, in the order in which they were made.
    pub fn id(&self) -> u64 {
        self.0.id
    }

    /// Radius of the smallest sphere about the origin that holds the shape.
    #[inline]
    pub fn bounding_radius(&self) -> f64 {
        self.0.bounding_radius
    }

    /// The least width, of the widths along the normals looked at: at most 0.1 % more than the least of all.
    #[inline]
    pub fn thickness(&self) -> f64 {
        self.0.thickness
    }

    /// Volume of the solid.
    pub fn volume(&self) -> f64 {
        self.0.volume
    }

    /// Moments of inertia of the solid about the body's axes, per unit density.
    pub fn unit_inertia(&self) -> DVec3 {
        self.0.unit_inertia
    }

    /// A length that is under every radius of curvature of the surface, as far as was seen: half the least one between
    /// the normals looked at.
    #[inline]
    pub(crate) fn roundness(&self) -> f64 {
        self.0.roundness
    }

    /// The largest over the smallest width.
    #[inline]
    pub(crate) fn aspect(&self) -> f64 {
        2.0 * self.0.bounding_radius / self.0.thickness
    }

    /// How far it reaches along the axes of space, on the side of each that it reaches farther on.
    pub(super) fn half_extents(&self, orientation: DQuat) -> DVec3 {
        let axes = DMat3::from_quat(orientation).transpose();
        let farther = |axis: DVec3| self.reach(axis).max(self.reach(-axis));
        DVec3::new(farther(axes.x_axis), farther(axes.y_axis), farther(axes.z_axis))
    }

    /// Whether the plane through the origin at right angles to the z of space mirrors it, as far as the normals looked
    /// at tell.
    pub(super) fn is_planar_symmetric(&self, orientation: DQuat) -> bool {
        let axis = orientation.inverse() * DVec3::Z;
        let mirrored = |n: DVec3| n - 2.0 * axis.dot(n) * axis;
        let tolerance = PLANAR_TOLERANCE * self.bounding_radius();
        let same = |n: DVec3| (self.reach(n) - self.reach(mirrored(n))).abs() <= tolerance;
        sample::directions(MIRROR_FREQUENCY, DVec3::ONE).all(same)
    }
}

/// Normals along a quarter of a great circle that a superellipsoid's least radius of curvature is looked for with.
const ROUNDNESS_FREQUENCY: usize = 48;

/// Normals along a quarter of a great circle that a mirror plane is looked for with: 1,032 in all.
const MIRROR_FREQUENCY: usize = 16;

impl PartialEq for Convex {
    fn eq(&self, other: &Convex) -> bool {
        self.0.id == other.0.id
    }
}

impl fmt::Debug for Convex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Measured { id, bounding_radius, thickness, .. } = self.0;
        f.debug_struct("Convex")
            .field("id", id)
            .field("bounding_radius", bounding_radius)
            .field("thickness", thickness)
            .finish()
    }
}
