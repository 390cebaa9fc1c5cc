//! Where rows come from: the smooth surfaces of a pair, or the sub-spheres of its two proxies.

use crate::separation::{Placed, Separation};
use crate::shape::{ProxyError, ProxySphere, Shape};
use glam::DVec3;

/// Tells apart the rows of one pair from one step to the next; all rows of smooth surfaces share this one.
pub const FEATURE_OF_SURFACES: u32 = 0;

/// What a contact method makes its first rows from.
#[derive(Clone, Debug, PartialEq)]
pub enum RowSource {
    /// One row a pair, from the shared-normal separation of the smooth surfaces.
    Surfaces,
    /// One row a near pair of sub-spheres.
    SubSpheres {
        /// Spheres a body.
        count: u32,
    },
}

/// A shape has no proxy with this number of spheres.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("body {body}: {source}")]
pub struct RowSourceError {
    /// The body.
    pub body: usize,
    /// Why.
    pub source: ProxyError,
}

impl RowSource {
    /// The proxies of all bodies in body axes; empty where rows are made from surfaces.
    pub fn proxies(&self, shapes: &[Shape]) -> Result<Vec<Vec<ProxySphere>>, RowSourceError> {
        match self {
            RowSource::Surfaces => Ok(Vec::new()),
            RowSource::SubSpheres { count } => shapes
                .iter()
                .enumerate()
                .map(|(body, shape)| shape.proxy(*count as usize).map_err(|source| RowSourceError { body, source }))
                .collect(),
        }
    }
}

/// Calls `found` with the separation of every pair of sub-spheres of `a` and `b` that is at most `limit`, and its
/// feature.
pub fn sub_sphere_separations(
    [a, b]: [&Placed; 2],
    [proxy_a, proxy_b]: [&[ProxySphere]; 2],
    limit: f64,
    mut found: impl FnMut(u32, Separation),
) {
    let delta = b.position - a.position;
    for (i, sphere_a) in proxy_a.iter().enumerate() {
        let arm_a = a.orientation * sphere_a.centre;
        for (j, sphere_b) in proxy_b.iter().enumerate() {
            let arm_b = b.orientation * sphere_b.centre;
            let between = delta + arm_b - arm_a;
            let distance = between.length();
            let separation = distance - sphere_a.radius - sphere_b.radius;
            if separation > limit {
                continue;
            }
            // Concentric sub-spheres have no normal of their own: push along z.
            let normal = if distance > 0.0 { between / distance } else { DVec3::Z };
            let feature = (i * proxy_b.len() + j) as u32;
            found(
                feature,
                Separation {
                    separation,
                    normal,
                    lever_a: arm_a + sphere_a.radius * normal,
                    lever_b: arm_b - sphere_b.radius * normal,
                },
            );
        }
    }
}
