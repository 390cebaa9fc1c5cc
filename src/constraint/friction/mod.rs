//! Coulomb friction and restitution of contacts: the coefficients of both, and the tangent rows of a contact.
//!
//! A contact with the normal `n`, the tangents `t1`, `t2` and the coefficient `mu` has a normal row as one without
//! friction, and a row a tangent, whose value at the total velocity `U` is the slip of the step, a length:
//!
//! ```text
//! s_i = dt t_i . (U_b(p) - U_a(p) + w) + k (gamma_i - gamma_i')
//! ```
//!
//! with `p` half-way between the surfaces, so that both forces act at one point, and `w` what moves the surfaces beside
//! their bodies: a wall's motion, an image's in a sheared cell, growth. What the three multipliers may be, and the law,
//! are in [`crate::lcp`] (`friction`): exact Signorini conditions and isotropic Coulomb friction.
//!
//! Stick has an elastic slip: `gamma'` is the friction force that the contact ended the last step with, and `k` a
//! compliance by which a mean contact at its limit has slipped by the scene's `contact.elastic_slip`. It is the
//! tangential spring of P. A. Cundall, O. D. L. Strack, Geotechnique 29, 47 (1979), implicit, and carried from step to
//! step: at rest the force stays and nothing creeps. Without it the exact law is ill posed at rest, where a contact
//! that slips by rounding must carry its full friction: a pile of ten spheres collapses.

mod coefficients;
#[cfg(feature = "files")]
pub(crate) mod number_or_object;
mod rows;
mod settings;

pub use coefficients::Coefficients;
pub(crate) use rows::{ElasticSlip, Sliding, tangents};
pub(crate) use settings::LARGEST_COEFFICIENT;
pub use settings::{Friction, GroupFriction, Restitution};
