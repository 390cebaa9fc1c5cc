//! How the medium resists a body's motion: alike in all directions, otherwise along its axis than across it, or as a
//! viscous fluid resists a body of its shape.
//!
//! | drag | along z | across z | turning |
//! | --- | --- | --- | --- |
//! | a number `xi` | `xi L` | `xi L` | `xi L^3 / 12` |
//! | `parallel`, `perpendicular`, `rotation` | `parallel L` | `perpendicular L` | `rotation L^3 / 12` |
//! | `viscosity` | that of Stokes flow about the body alone, about each of its axes ([`fluid`]) | | |
//!
//! with `L` the largest extent. For a rod with the same drag on each piece of its length `rotation` is `perpendicular`.
//! A sphere has no axis: of `parallel` and `perpendicular` it has the mean over all directions.

pub(crate) mod fluid;
#[cfg(feature = "files")]
mod json;

use super::along::Along;
use crate::shape::Shape;
use glam::DVec3;

/// The drag of bodies. A number in a scene file is [`Drag::Even`].
///
/// ```
/// use relcp::scene::Drag;
/// assert_eq!(Drag::from(1.5), Drag::Even(1.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Drag {
    /// The same in all directions: resistances `xi L` to motion and `xi L^3 / 12` to turning.
    Even(f64),
    /// Another along the body's z than across it.
    Axes {
        /// Resistance to motion along z, over the body's length.
        parallel: f64,
        /// Resistance to motion across z, over the body's length.
        perpendicular: f64,
        /// Resistance to turning about any axis, over a twelfth of the length's third power.
        rotation: f64,
    },
    /// That of a fluid of this viscosity about the body alone, without inertia of the fluid.
    Viscosity(f64),
}

impl From<f64> for Drag {
    fn from(xi: f64) -> Drag {
        Drag::Even(xi)
    }
}

/// The resistances of a body: force over velocity, and torque over angular velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resistance {
    /// To motion.
    pub linear: Along,
    /// To turning.
    pub turning: Along,
}

impl Drag {
    /// The resistances of a body of this shape.
    ///
    /// ```
    /// use relcp::scene::Drag;
    /// use relcp::shape::Shape;
    /// let ball = Drag::Viscosity(1.0).resistance(&Shape::Sphere { radius: 0.5 });
    /// assert!((ball.linear.largest() - 3.0 * std::f64::consts::PI).abs() < 1e-12);
    /// ```
    pub fn resistance(&self, shape: &Shape) -> Resistance {
        let length = shape.major_axis();
        match *self {
            Drag::Even(xi) => {
                Resistance { linear: Along::Even(xi * length), turning: Along::Even(xi * length.powi(3) / 12.0) }
            }
            Drag::Axes { parallel, perpendicular, rotation } => {
                let linear = match shape {
                    Shape::Sphere { .. } => Along::Even((parallel + 2.0 * perpendicular) / 3.0 * length),
                    _ => Along::Axes(length * DVec3::new(perpendicular, perpendicular, parallel)),
                };
                Resistance { linear, turning: Along::Even(rotation * length.powi(3) / 12.0) }
            }
            Drag::Viscosity(viscosity) => fluid::resistance(viscosity, shape),
        }
    }

    /// Bretherton's constants of the body about its axes: those of [`Shape::bretherton`], except that a rod and a ring
    /// in a viscous fluid have those of their thickness. `None` for a shape of one's own.
    pub fn bretherton(&self, shape: &Shape) -> Option<DVec3> {
        match self {
            Drag::Viscosity(_) => fluid::bretherton(shape),
            _ => shape.bretherton(),
        }
    }

    /// The one coefficient, of drag that is the same in all directions.
    pub fn even(&self) -> Option<f64> {
        match *self {
            Drag::Even(xi) => Some(xi),
            _ => None,
        }
    }

    /// The coefficients with their keys. Drag that is a number is one coefficient without a key.
    pub(crate) fn coefficients(&self) -> Vec<(Option<&'static str>, f64)> {
        match *self {
            Drag::Even(xi) => vec![(None, xi)],
            Drag::Axes { parallel, perpendicular, rotation } => {
                vec![(Some("parallel"), parallel), (Some("perpendicular"), perpendicular), (Some("rotation"), rotation)]
            }
            Drag::Viscosity(viscosity) => vec![(Some("viscosity"), viscosity)],
        }
    }
}

impl Resistance {
    /// The least one to motion, in any direction.
    pub fn least(&self) -> f64 {
        self.linear.least()
    }
}
