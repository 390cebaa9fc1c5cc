//! A chain as a random walk that avoids itself, earlier bodies and walls.
//!
//! Each direction is drawn uniformly within the largest bend from the last one. Where no draw of several is free, the
//! walk goes back: by one body, and by twice as many each time that it comes no farther.

use super::super::error::{FaultKind, SceneError};
use super::chain::{Link, Links, Place};
use super::isotropic::{rotation, rotation_in_plane, stream};
use super::occupied::{Occupied, capsule};
use super::{Chain, GoesOn};
use crate::bodies::Bodies;
use crate::shape::Shape;
use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Draws of a body before the walk goes back.
const DRAWS_A_BODY: u32 = 64;
/// Draws of a chain before placement counts as failed: so many, and so many a body. Half a second of them.
const MOST_DRAWS: u64 = 500_000;
const MORE_A_BODY: u64 = 500;
/// Draws between two calls of `goes_on`.
const DRAWS_A_QUESTION: u64 = 2_048;

/// Walks of one rule.
pub(super) struct Walk<'a> {
    place: &'a Place<'a>,
    links: Links,
    shape: Shape,
    count: usize,
    bend: f64,
    random: ChaCha8Rng,
    occupied: Occupied,
    /// The bodies before the walk.
    before: usize,
}

impl<'a> Walk<'a> {
    /// Walks with bends up to `bend` radians, beside `bodies`.
    pub fn new(place: &'a Place<'a>, links: Links, chain: &Chain, bend: f64, bodies: &Bodies) -> Self {
        let mut occupied = Occupied::new(bodies.periods);
        for i in 0..bodies.len() {
            occupied.insert(capsule(&bodies.shape[i], bodies.position[i], bodies.orientation[i]));
        }
        let random = stream(place.scene.seed, place.rule);
        let (shape, count, before) = (chain.shape, chain.count as usize, bodies.len());
        Walk { place, links, shape, count, bend, random, occupied, before }
    }

    /// The links of one chain, from the first end of its first body.
    pub fn links(&mut self, start: DVec3, goes_on: GoesOn) -> Result<Vec<Link>, SceneError> {
        let mut found: Vec<Link> = Vec::new();
        let (mut draws, mut tries, mut farthest, mut back) = (0, 0, 0, 1);
        let most = MOST_DRAWS.saturating_add(MORE_A_BODY.saturating_mul(self.count as u64));
        while found.len() < self.count {
            draws += 1;
            if draws % DRAWS_A_QUESTION == 0 && !goes_on(self.before + found.len()) {
                let message = format!("stopped after {} of {} bodies were placed", found.len(), self.count);
                return Err(self.place.fault(FaultKind::Interrupted, "count", message));
            }
            if draws > most {
                return Err(self.full(farthest));
            }
            let link = self.next(start, found.last());
            if self.is_free(link) {
                self.occupied.insert(self.capsule(link));
                found.push(link);
                tries = 0;
                if found.len() > farthest {
                    (farthest, back) = (found.len(), 1);
                }
                continue;
            }
            tries += 1;
            if tries == DRAWS_A_BODY {
                for _ in 0..back.min(found.len()) {
                    if let Some(last) = found.pop() {
                        self.occupied.remove_last(&self.capsule(last));
                    }
                }
                (tries, back) = (0, (2 * back).min(self.count));
            }
        }
        self.before += self.count;
        Ok(found)
    }

    /// A draw of the link after `last`.
    fn next(&mut self, start: DVec3, last: Option<&Link>) -> Link {
        let Links { reach, rest } = self.links;
        let Some((position, direction)) = last else {
            let planar = self.place.scene.planar;
            let turn = if planar { rotation_in_plane(&mut self.random) } else { rotation(&mut self.random) };
            let direction = turn * DVec3::Z;
            // Without the rounding of the turn, so that all of the walk is in the plane.
            let direction = if planar { direction.with_z(0.0).normalize() } else { direction };
            return (start + reach * direction, direction);
        };
        let next = self.bent(*direction);
        // A bond lies halfway between the axes of rods; that of balls is the step itself.
        let across = if reach == 0.0 { next } else { (*direction + next).normalize_or(next) };
        (*position + reach * (*direction + next) + rest * across, next)
    }

    /// A direction within the bend from another, all equally likely.
    fn bent(&mut self, from: DVec3) -> DVec3 {
        if self.place.scene.planar {
            let angle = self.bend * (2.0 * self.random.random::<f64>() - 1.0);
            let (sine, cosine) = angle.sin_cos();
            return DVec3::new(cosine * from.x - sine * from.y, sine * from.x + cosine * from.y, 0.0).normalize();
        }
        let cosine = 1.0 - self.random.random::<f64>() * (1.0 - self.bend.cos());
        let (first, second) = from.any_orthonormal_pair();
        loop {
            let [x, y] = self.random.random::<[f64; 2]>().map(|u| 2.0 * u - 1.0);
            let square = x * x + y * y;
            if square < 1.0 && square > 0.0 {
                let aside = (x * first + y * second) / square.sqrt();
                return (cosine * from + (1.0 - cosine * cosine).max(0.0).sqrt() * aside).normalize();
            }
        }
    }

    fn capsule(&self, link: Link) -> crate::separation::Placed {
        let body = self.place.body(self.shape, link);
        capsule(&self.shape, body.position, body.orientation)
    }

    fn is_free(&self, link: Link) -> bool {
        let body = self.place.body(self.shape, link);
        !self.occupied.overlaps(&self.capsule(link)) && self.place.walls.deepest(&body).is_none()
    }

    fn full(&self, placed: usize) -> SceneError {
        let message =
            format!("at most {placed} of {} bodies were placed; no free place was found for the next", self.count);
        let help = "choose a wider gap, a smaller largest_bend, a shorter chain, or another start";
        self.place.fault(FaultKind::Placement, "path.random_walk", message).with_help(help)
    }
}
