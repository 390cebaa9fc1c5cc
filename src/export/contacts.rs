//! The contacts of a state, with the forces that its checkpoint knows.

use super::states::Snapshot;
use crate::relcp::image_contacts;
use crate::separation::{Separation, separation};
use crate::walls::surface_of;
use glam::{DVec3, I64Vec3};
use std::collections::BTreeMap;

/// Pairs nearer than this fraction of the least thickness of a body are contacts, without another cutoff.
///
/// In a colony of 1,024 cells (dt = 0.001), the farthest of 1,967 pairs that push each other are 9.1e-4 of it apart, and only 12
/// other pairs are nearer; of 4,676 such pairs among 1,000 jammed ellipsoids, none is farther apart than 1e-5.
pub const TOUCHING: f64 = 1e-3;

/// A contact of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The bodies, by their rows.
    pub pair: [usize; 2],
    /// What the second body is moved by to the image that the first one meets; zero where space has no periods.
    pub shift: DVec3,
    /// Half-way between the surfaces, at the first body and that image.
    pub point: DVec3,
    /// The signed distance of the surfaces; negative where they overlap.
    pub separation: f64,
    /// From the first body to the second.
    pub normal: DVec3,
    /// The force that they push each other with, along the normal; not a number where it is not known.
    pub gamma: f64,
}

/// The contacts of a state, sorted by pair: pairs nearer than `cutoff` (without it, [`TOUCHING`] of the least thickness), and those
/// that push each other, however far apart the step left them. Contacts with walls are not among them. In periodic space each image of a pair that is
/// near is a contact, and a cutoff over the shortest period counts as that.
///
/// ```
/// use relcp::export::{States, contacts};
/// let states = States::open("three-capsules")?;
/// let found = contacts(&*states.read(0)?, Some(0.5));
/// assert!(found.iter().all(|contact| contact.separation <= 0.5 && contact.gamma.is_nan()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contacts(state: &Snapshot, cutoff: Option<f64>) -> Vec<Contact> {
    let bodies = &state.bodies;
    let thickness = bodies.shape.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min);
    let cutoff = cutoff.unwrap_or(if thickness.is_finite() { TOUCHING * thickness } else { 0.0 });
    let key = |pair: [usize; 2], image: I64Vec3| (pair, image.to_array());
    let near = image_contacts(bodies, cutoff).into_iter();
    let mut found: BTreeMap<_, Separation> = near.map(|near| (key(near.pair, near.image), near.found)).collect();
    let mut forces = BTreeMap::new();
    for warm in state.warm.iter().flatten().filter(|warm| surface_of(warm.pair[1]).is_none()) {
        let pair = warm.pair.map(|body| body as usize);
        let image = bodies.periods.nearest_image(bodies.position[pair[1]] - bodies.position[pair[0]]);
        let key = key(pair, image);
        // A method that makes several rows of a pair remembers each.
        *forces.entry(key).or_default() += warm.gamma;
        if warm.gamma > 0.0 && !found.contains_key(&key) {
            let [a, b] = bodies.pair(pair[0], pair[1]);
            found.extend(separation(&a, &b, None).map(|separation| (key, separation)));
        }
    }
    let unknown = if state.warm.is_some() { 0.0 } else { f64::NAN };
    let contact = |(key, s): (([usize; 2], [i64; 3]), Separation)| {
        let (pair, image) = key;
        let shift = bodies.periods.shift(image.into());
        Contact {
            pair,
            shift,
            point: 0.5 * (bodies.position[pair[0]] + s.lever_a + (bodies.position[pair[1]] + shift) + s.lever_b),
            separation: s.separation,
            normal: s.normal,
            gamma: forces.get(&key).copied().unwrap_or(unknown),
        }
    };
    found.into_iter().map(contact).collect()
}
