//! The resistances of a body in Stokes flow: a viscous fluid without bounds and without inertia, at rest on the body.
//!
//! * **Ellipsoids** (and spheres): exact, by elliptic integrals ([`ellipsoid`]).
//! * **Spherocylinders and tori**: no closed form in few terms is known. Fits to a computation by fundamental
//!   solutions, which `tests/physics/stokes.rs` does again ([`rod`], [`ring`]).

mod ellipsoid;
pub(crate) mod ring;
pub(crate) mod rod;

use super::Resistance;
use crate::dynamics::along::Along;
use crate::shape::Shape;
use glam::DVec3;
use std::f64::consts::PI;

/// The resistances of a body of this shape in a fluid of this viscosity.
pub fn resistance(viscosity: f64, shape: &Shape) -> Resistance {
    let of_axes = |[linear, turning]: [DVec3; 2]| Resistance {
        linear: Along::Axes(viscosity * linear),
        turning: Along::Axes(viscosity * turning),
    };
    match *shape {
        Shape::Sphere { radius } => of_sphere(viscosity, radius),
        Shape::Spherocylinder { diameter, length } if length > diameter => {
            of_axes(rod::resistances(0.5 * diameter, 0.5 * length))
        }
        Shape::Spherocylinder { diameter, .. } => of_sphere(viscosity, 0.5 * diameter),
        Shape::Ellipsoid { radii } => of_axes(ellipsoid::resistances(DVec3::from_array(radii))),
        Shape::Torus { major_radius, minor_radius } => of_axes(ring::resistances(major_radius, minor_radius)),
        // Validation refuses these.
        Shape::Superellipsoid(_) | Shape::Convex(_) => of_sphere(viscosity, shape.bounding_radius()),
    }
}

fn of_sphere(viscosity: f64, radius: f64) -> Resistance {
    Resistance {
        linear: Along::Even(6.0 * PI * viscosity * radius),
        turning: Along::Even(8.0 * PI * viscosity * radius.powi(3)),
    }
}

/// Bretherton's constants about the axes of a body of this shape.
pub fn bretherton(shape: &Shape) -> Option<DVec3> {
    let of_revolution = |constant: f64| Some(DVec3::new(-constant, constant, 0.0));
    match *shape {
        Shape::Spherocylinder { diameter, length } => of_revolution(rod::bretherton(0.5 * diameter, 0.5 * length)),
        Shape::Torus { major_radius, minor_radius } => of_revolution(ring::bretherton(major_radius, minor_radius)),
        _ => shape.bretherton(),
    }
}
