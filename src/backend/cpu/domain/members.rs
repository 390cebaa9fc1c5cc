//! Bodies with what processes know of them, and how they are packed into words for messages.

use crate::bodies::{Bodies, Lineage, kept};
use crate::shape::Shape;
use glam::{DQuat, DVec3};

/// Words of a body.
pub(super) const BODY: usize = 23;

/// Words of a [`Member`].
pub(super) const MEMBER: usize = 4 + BODY;

/// What processes know of a body of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Known {
    /// Its global index.
    pub number: u32,
    /// Its position in the global block order.
    pub place: u32,
    /// How far it may go in the step.
    pub way: f64,
    /// What slows its growth.
    pub slowing: f64,
}

/// A body in a message: its owner and its words.
pub(super) type Member = (u32, [u64; MEMBER]);

/// Some bodies of a step, by global index.
#[derive(Debug, Default)]
pub(super) struct Members {
    pub known: Vec<Known>,
    pub owner: Vec<u32>,
    pub bodies: Bodies,
}

impl Members {
    /// Unpacks words, in any order; `like` has the data that belongs to no body.
    pub fn new(mut words: Vec<Member>, like: &Bodies) -> Self {
        words.sort_unstable_by_key(|(_, words)| words[0]);
        let mut members = Members { known: Vec::new(), owner: Vec::new(), bodies: like.none_like() };
        for (owner, [number, place, way, slowing, body @ ..]) in words {
            let (way, slowing) = (f64::from_bits(way), f64::from_bits(slowing));
            members.known.push(Known { number: number as u32, place: place as u32, way, slowing });
            members.owner.push(owner);
            push(&mut members.bodies, &body);
        }
        members
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.known.len()
    }

    /// A body's words.
    pub fn words(&self, i: usize) -> [u64; MEMBER] {
        words(&self.known[i], &self.bodies, i)
    }

    /// All of them.
    pub fn into_words(self) -> Vec<Member> {
        (0..self.len()).map(|i| (self.owner[i], self.words(i))).collect()
    }

    /// Keeps the flagged ones.
    pub fn retain(&mut self, keep: &[bool]) {
        kept(&mut self.known, keep);
        kept(&mut self.owner, keep);
        self.bodies.retain(keep);
    }

    /// The local index of a body.
    pub fn find(&self, number: u32) -> Option<usize> {
        self.known.binary_search_by_key(&number, |known| known.number).ok()
    }
}

/// The words of a body and of what is known of it.
pub(super) fn words(known: &Known, bodies: &Bodies, i: usize) -> [u64; MEMBER] {
    let mut words = [0; MEMBER];
    let Known { number, place, way, slowing } = *known;
    words[..4].copy_from_slice(&[number.into(), place.into(), way.to_bits(), slowing.to_bits()]);
    words[4..].copy_from_slice(&pack(bodies, i));
    words
}

/// The words of body `i`.
pub(super) fn pack(bodies: &Bodies, i: usize) -> [u64; BODY] {
    let (tag, sizes) = bodies.shape[i].code();
    let [a, b, c] = sizes.map(f64::to_bits);
    let of = |vector: DVec3| vector.to_array().map(f64::to_bits);
    let [x, y, z] = of(bodies.position[i]);
    let [p, q, r, s] = bodies.orientation[i].to_array().map(f64::to_bits);
    let [u, v, w] = of(bodies.velocity[i]);
    let [k, l, m] = of(bodies.angular_velocity[i]);
    let [id, parent, birth, generation, length] = bodies.lineage[i].words();
    let group = bodies.group[i].into();
    [tag.into(), a, b, c, x, y, z, p, q, r, s, u, v, w, k, l, m, group, id, parent, birth, generation, length]
}

/// Adds the body of these words. Custom shapes are refused before.
pub(super) fn push(bodies: &mut Bodies, words: &[u64; BODY]) {
    let [tag, a, b, c, x, y, z, p, q, r, s, u, v, w, k, l, m, group, line @ ..] = *words;
    let of = |words: [u64; 3]| DVec3::from_array(words.map(f64::from_bits));
    let sizes = [a, b, c].map(f64::from_bits);
    let Some((shape, _)) = Shape::of_code(tag as u32, sizes) else { return };
    bodies.shape.push(shape);
    bodies.position.push(of([x, y, z]));
    bodies.orientation.push(DQuat::from_array([p, q, r, s].map(f64::from_bits)));
    bodies.velocity.push(of([u, v, w]));
    bodies.angular_velocity.push(of([k, l, m]));
    bodies.group.push(group as u32);
    bodies.lineage.push(Lineage::of_words(line));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separation::Placed;

    #[test]
    fn a_body_arrives_as_it_was_sent() {
        let shapes = [
            Shape::Sphere { radius: 0.5 },
            Shape::Spherocylinder { diameter: 1.0, length: 3.25 },
            Shape::Ellipsoid { radii: [1.0, 2.0, 3.0] },
            Shape::Torus { major_radius: 2.0, minor_radius: 0.5 },
        ];
        let mut bodies = Bodies::default();
        for (i, shape) in shapes.into_iter().enumerate() {
            let at = DVec3::new(i as f64, -0.0, 1e-300);
            bodies.push(Placed { shape, position: at, orientation: DQuat::from_xyzw(0.5, 0.5, -0.5, 0.5) }, u32::MAX);
            bodies.velocity[i] = DVec3::new(0.1, f64::INFINITY, 0.3);
            bodies.angular_velocity[i] = DVec3::splat(i as f64);
            let parent = (i % 2 == 0).then_some(i as u64);
            let birth_length = (i > 1).then_some(2.5);
            bodies.lineage[i] = Lineage { id: 7, parent, birth: 0.25, generation: u32::MAX, birth_length };
        }
        let known = |i: u32| Known { number: i, place: 9 - i, way: 0.5, slowing: -1.0 };
        let all: Vec<Member> = (0..4).rev().map(|i| (i, words(&known(i), &bodies, i as usize))).collect();
        let arrived = Members::new(all.clone(), &bodies);
        assert_eq!(arrived.bodies, bodies);
        assert_eq!((arrived.owner.as_slice(), arrived.known[2]), (&[0, 1, 2, 3][..], known(2)));
        assert_eq!((arrived.find(3), arrived.find(4)), (Some(3), None));
        assert!(arrived.into_words().into_iter().rev().eq(all));
    }
}
