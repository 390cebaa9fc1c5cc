//! The contacts of a state, with the forces from its checkpoint.

use super::states::Snapshot;
use crate::separation::{Separation, branch, separate_in};
use crate::step;
use crate::walls::surface_of;
use glam::{DVec3, I64Vec3};
use std::collections::BTreeMap;

/// The default cutoff: pairs nearer than this fraction of the smallest thickness of a body are contacts.
///
/// In a colony of 1,024 cells (dt = 0.001), the farthest of 1,967 pairs that push each other are 9.1e-4 of it apart,
/// and only 12 other pairs are nearer; of 4,676 such pairs among 1,000 jammed ellipsoids, none is farther apart than
/// 1e-5.
pub const TOUCHING: f64 = 1e-3;

/// A contact of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactForce {
    /// The bodies, by their rows.
    pub pair: [usize; 2],
    /// The displacement from the second body to its image that the first one touches; zero without periods.
    pub shift: DVec3,
    /// Half-way between the surfaces, at the first body and that image.
    pub point: DVec3,
    /// The signed distance of the surfaces; negative if they overlap.
    pub separation: f64,
    /// From the first body to the second.
    pub normal: DVec3,
    /// The contact force along the normal; NaN if unknown.
    pub gamma: f64,
    /// The friction force on the second body, across the normal; zero without friction, NaN if unknown.
    pub tangent: DVec3,
}

impl ContactForce {
    /// The force on the second body.
    pub fn force(&self) -> DVec3 {
        self.gamma * self.normal + self.tangent
    }
}

/// The forces of a pair: their sum, their number, and the sums of normals and levers times forces.
#[derive(Clone, Copy, Default)]
struct Force {
    gamma: f64,
    tangent: DVec3,
    places: u32,
    normal: DVec3,
    levers: [DVec3; 2],
}

/// The contacts of a state, sorted by pair: pairs nearer than `cutoff` (without it, [`TOUCHING`] of the least
/// thickness), and those that push each other, at any distance. Contacts with walls are not included. In periodic space
/// each near image of a pair is a contact, and the cutoff is at most the shortest period.
///
/// ```
/// use relcp::record::{States, contacts};
/// let states = States::open("three-capsules")?;
/// let found = contacts(&*states.read(0)?, Some(0.5));
/// assert!(found.iter().all(|contact| contact.separation <= 0.5 && contact.gamma.is_nan()));
/// # Ok::<(), relcp::Error>(())
/// ```
pub fn contacts(state: &Snapshot, cutoff: Option<f64>) -> Vec<ContactForce> {
    let bodies = &state.bodies;
    let thickness = bodies.shape.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min);
    let cutoff = cutoff.unwrap_or(if thickness.is_finite() { TOUCHING * thickness } else { 0.0 });
    let key = |pair: [usize; 2], image: I64Vec3| (pair, image.to_array());
    let mut found: BTreeMap<_, Separation> = BTreeMap::new();
    for step::Contact { bodies, image, separation, normal, levers: [lever_a, lever_b] } in
        step::contacts(bodies, cutoff)
    {
        found.insert(key(bodies, image), Separation { separation, normal, lever_a, lever_b });
    }
    let mut forces = BTreeMap::<_, Force>::new();
    for warm in state.warm.iter().flatten().filter(|warm| surface_of(warm.pair[1]).is_none()) {
        let pair = warm.pair.map(|body| body as usize);
        let image = bodies.periods.nearest_image(bodies.position[pair[1]] - bodies.position[pair[0]]);
        let key = key(pair, image);
        let [a, b] = bodies.pair(pair[0], pair[1]);
        if warm.gamma > 0.0 && !found.contains_key(&key) {
            found.extend(separate_in(bodies.planar)(&a, &b, None).map(|separation| (key, separation)));
        }
        // Methods with several rows per pair have a force for each.
        let force = forces.entry(key).or_default();
        force.gamma += warm.gamma;
        force.tangent += warm.tangent;
        if let Some(nearest) = found.get(&key).filter(|_| warm.gamma > 0.0) {
            force.places += 1;
            let at = branch(&a, &b, nearest, warm.feature);
            force.normal += warm.gamma * at.normal;
            force.levers = [force.levers[0] + warm.gamma * at.lever_a, force.levers[1] + warm.gamma * at.lever_b];
        }
    }
    // If a pair pushes at several points, its contact is their resultant.
    for (key, found) in &mut found {
        if let Some(force) = forces.get(key).filter(|force| force.places > 1) {
            found.normal = force.normal.try_normalize().unwrap_or(found.normal);
            (found.lever_a, found.lever_b) = (force.levers[0] / force.gamma, force.levers[1] / force.gamma);
        }
    }
    let unknown = if state.warm.is_some() { 0.0 } else { f64::NAN };
    let contact = |(key, s): (([usize; 2], [i64; 3]), Separation)| {
        let (pair, image) = key;
        let shift = bodies.periods.shift(image.into());
        ContactForce {
            pair,
            shift,
            point: 0.5 * (bodies.position[pair[0]] + s.lever_a + (bodies.position[pair[1]] + shift) + s.lever_b),
            separation: s.separation,
            normal: s.normal,
            gamma: forces.get(&key).map_or(unknown, |force| force.gamma),
            tangent: forces.get(&key).map_or(DVec3::splat(unknown), |force| force.tangent),
        }
    };
    found.into_iter().map(contact).collect()
}
