//! The contacts of a state, computed afresh: what audits the steps.

use crate::bodies::Bodies;
use crate::broad_phase::{Aabb, BroadPhase, Grid, Periodic};
use crate::fixed::Fixed;
use crate::separation::{Placed, Separation, separate_in};
use crate::walls::Walls;
use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

/// Two bodies that are near, and where: the shared-normal signed distance of a pair, in periodic space at one of its
/// images.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Contact {
    /// The rows of both bodies, the lower first. In periodic space a body may be near its own images: both are then the
    /// same, and one of each two opposite images is listed.
    pub bodies: [usize; 2],
    /// The periods by which the second body is moved along each axis; zero in space without periods.
    pub image: I64Vec3,
    /// `Phi`: the distance between the surfaces along the normal, a length; negative where they overlap.
    pub separation: f64,
    /// Unit normal from the first body to the second.
    pub normal: DVec3,
    /// From each body's centre to the contact point on its surface.
    pub levers: [DVec3; 2],
}

impl Contact {
    pub(crate) fn new(Candidate { bodies, image }: Candidate, found: Separation) -> Contact {
        let Separation { separation, normal, lever_a, lever_b } = found;
        Contact { bodies, image, separation, normal, levers: [lever_a, lever_b] }
    }

    /// The contact points on both surfaces, in space: the second one on the [image](Contact::image) that is near.
    /// `bodies` are those that the contact was found in.
    ///
    /// # Panics
    /// If `bodies` has fewer bodies than those.
    pub fn points(&self, bodies: &Bodies) -> [DVec3; 2] {
        let [a, b] = self.bodies.map(|i| bodies.position[i]);
        [a + self.levers[0], b + bodies.periods.shift(self.image) + self.levers[1]]
    }
}

/// Two bodies that may be near, the second at an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    pub bodies: [usize; 2],
    pub image: I64Vec3,
}

/// Every pair of bodies whose separation is at most `cutoff`, sorted by pair and image, computed afresh from the bodies
/// alone: it shares no cached candidates, warm normals or shortcuts with the steps, so it audits them. In periodic
/// space a pair is listed once for each of its images that is near, and a cutoff over the shortest period counts as
/// that. Of bodies that cannot leave the plane, separations are those in it. Pairs that a bond keeps from colliding are
/// left out.
///
/// ```
/// # #[cfg(feature = "files")] {
/// let bodies = relcp::Scene::built_in("three-capsules")?.build()?;
/// let near = relcp::contacts(&bodies, 0.0);
/// assert_eq!(near.len(), 2);
/// let [a, b] = near[0].points(&bodies);
/// assert!(((b - a).dot(near[0].normal) - near[0].separation).abs() < 1e-12);
/// # }
/// # Ok::<(), relcp::Error>(())
/// ```
pub fn contacts(bodies: &Bodies, cutoff: f64) -> Vec<Contact> {
    let (cutoff, found) = candidates(bodies, cutoff);
    let separate = separate_in(bodies.planar);
    let near = |candidate: &Candidate| {
        let [a, b] = candidate.bodies.map(|i| bodies.placed(i));
        let found = match bodies.periods.is_none() {
            true => separate(&a, &b, None)?,
            false => {
                let delta = b.position - a.position + bodies.periods.shift(candidate.image);
                separate(&Placed { position: DVec3::ZERO, ..a }, &Placed { position: delta, ..b }, None)?
            }
        };
        (found.separation <= cutoff).then(|| Contact::new(*candidate, found))
    };
    found.par_iter().filter_map(near).collect()
}

/// Every pair whose boxes are within `cutoff` of each other, sorted by pair and image; and the cutoff that counts.
pub(crate) fn candidates(bodies: &Bodies, cutoff: f64) -> (f64, Vec<Candidate>) {
    let periods = bodies.periods;
    let cutoff = periods.shortest().map_or(cutoff, |period| cutoff.min(period));
    let boxes: Vec<Aabb> = (0..bodies.len())
        .map(|i| {
            let half = bodies.shape[i].half_extents(bodies.orientation[i]) + DVec3::splat(0.5 * cutoff.max(0.0));
            Aabb { min: bodies.position[i] - half, max: bodies.position[i] + half }
        })
        .collect();
    let mut pairs = Vec::new();
    Periodic::new(Grid::default(), periods).pairs(&boxes, &mut pairs);
    let but = bodies.without_contact();
    if !but.is_empty() {
        pairs.retain(|pair| but.binary_search(pair).is_err());
    }
    if !periods.is_none() {
        pairs.extend((0..boxes.len() as u32).map(|i| [i, i]));
        pairs.par_sort_unstable();
    }
    let of_pair = |pair: &[u32; 2]| {
        let pair = pair.map(|i| i as usize);
        let mut images = Vec::new();
        if periods.is_none() {
            images.push(I64Vec3::ZERO);
        } else {
            periods.images(&boxes[pair[0]], &boxes[pair[1]], |[first, last]| images.extend(all_between(first, last)));
            images.sort_unstable_by_key(I64Vec3::to_array);
        }
        // Of a body and its own images, one of each two opposite ones.
        let counts = move |image: &I64Vec3| pair[0] != pair[1] || image.to_array() > [0; 3];
        images.into_iter().filter(counts).map(move |image| Candidate { bodies: pair, image })
    };
    (cutoff, pairs.par_iter().flat_map_iter(of_pair).collect())
}

fn all_between(first: I64Vec3, last: I64Vec3) -> impl Iterator<Item = I64Vec3> {
    let along = move |axis: usize| first[axis]..=last[axis];
    along(0).flat_map(move |x| along(1).flat_map(move |y| along(2).map(move |z| I64Vec3::new(x, y, z))))
}

/// The deepest overlap of bodies as they are, with each other and with walls, from [`contacts`] and [`Walls::contacts`]
/// afresh: zero where none overlap.
pub fn max_overlap(bodies: &Bodies, walls: &Walls) -> f64 {
    max_overlap_but(&Fixed::default(), bodies, walls)
}

/// As [`max_overlap`], without the overlaps of fixed bodies with each other and with walls: nothing
/// parts them.
pub(crate) fn max_overlap_but(fixed: &Fixed, bodies: &Bodies, walls: &Walls) -> f64 {
    let deeper = |worst: f64, overlap: f64| if overlap > worst { overlap } else { worst };
    let held = |i: &usize| fixed.holds(bodies.lineage[*i].id, bodies.group[*i]);
    let at_walls = walls.contacts(bodies, 0.0).into_iter().filter(|contact| !held(&contact.body));
    let past_walls = at_walls.map(|contact| -contact.separation).fold(0.0, deeper);
    let counts = |contact: &&Contact| !contact.bodies.iter().all(held);
    contacts(bodies, 0.0).iter().filter(counts).map(|contact| -contact.separation).fold(past_walls, deeper)
}

/// The pair of bodies that overlaps most, and by how much; none where no pair does. Not of two fixed bodies.
#[cfg(feature = "files")]
pub(crate) fn deepest_pair_but(fixed: &Fixed, bodies: &Bodies) -> Option<([usize; 2], f64)> {
    let held = |i: &usize| fixed.holds(bodies.lineage[*i].id, bodies.group[*i]);
    let pairs = contacts(bodies, 0.0).into_iter().filter(|contact| !contact.bodies.iter().all(held));
    let overlaps = pairs.map(|contact| (contact.bodies, -contact.separation)).filter(|(_, overlap)| *overlap > 0.0);
    // The first of equal ones.
    overlaps.reduce(|deepest, next| if next.1 > deepest.1 { next } else { deepest })
}
