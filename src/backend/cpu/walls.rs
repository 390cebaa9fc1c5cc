//! What of a step concerns walls: which bodies are near them, and which reach past them.

use super::narrow_phase::Near;
use super::{Cpu, LEAST_BODIES_A_TASK};
use crate::separation::{Placed, Separation};
use crate::walls::{number_of, surface_of};
use glam::DVec3;
use rayon::prelude::*;

impl<const D: usize> Cpu<D> {
    /// The places of all bodies whose gap to a surface is at most `limit(body)`, in the order of bodies, surfaces and
    /// places.
    pub(super) fn near_walls(
        &self,
        placed: impl Fn(usize) -> Placed + Sync,
        limit: impl Fn(usize) -> f64 + Sync,
    ) -> Vec<Near> {
        self.along_walls(placed, limit, |placed, _, surface, found| {
            self.walls.surfaces()[surface].places(placed, found)
        })
    }

    /// The sub-spheres of all bodies, likewise.
    pub(super) fn sub_spheres_near_walls(
        &self,
        placed: impl Fn(usize) -> Placed + Sync,
        limit: impl Fn(usize) -> f64 + Sync,
    ) -> Vec<Near> {
        self.along_walls(placed, limit, |placed, body, surface, found| {
            self.sub_sphere_gaps(placed, body, surface, found)
        })
    }

    /// Calls `found` with the gap of each sub-sphere of `body`.
    fn sub_sphere_gaps(&self, placed: &Placed, body: usize, surface: usize, found: &mut dyn FnMut(u32, Separation)) {
        for (sphere, number) in self.proxies[body].iter().zip(0..) {
            let arm = placed.orientation * sphere.centre;
            found(number, self.walls.surfaces()[surface].at(placed.position, arm, sphere.radius));
        }
    }

    fn along_walls(
        &self,
        placed: impl Fn(usize) -> Placed + Sync,
        limit: impl Fn(usize) -> f64 + Sync,
        places: impl Fn(&Placed, usize, usize, &mut dyn FnMut(u32, Separation)) + Sync,
    ) -> Vec<Near> {
        if self.walls.is_empty() {
            return Vec::new();
        }
        let of_body = |body: usize| {
            let (placed, limit) = (placed(body), limit(body));
            let mut near = Vec::new();
            for (surface, at) in self.walls.surfaces().iter().enumerate() {
                if at.bound(&placed) > limit {
                    continue;
                }
                let pair = [body as u32, number_of(surface)];
                places(&placed, body, surface, &mut |feature, found| {
                    if found.separation <= limit {
                        near.push(Near { pair, feature, found });
                    }
                });
            }
            near
        };
        let bodies = self.start.len();
        (0..bodies).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).flat_map_iter(of_body).collect()
    }

    /// The deepest that a sub-sphere of `near`'s body reaches past its surface at the trial.
    pub(super) fn proxy_past_wall(&self, near: &Near) -> f64 {
        let (body, Some(surface)) = (near.pair[0] as usize, surface_of(near.pair[1])) else { return 0.0 };
        let mut deepest = 0.0_f64;
        self.sub_sphere_gaps(&self.placed_at_trial(body), body, surface, &mut |_, found| {
            deepest = deepest.max(-found.separation);
        });
        deepest
    }

    /// The normal at a place of a body towards a surface, at the trial.
    pub(super) fn wall_normal(&self, body: usize, surface: usize, feature: u32) -> DVec3 {
        let mut normal = DVec3::ZERO;
        self.walls.surfaces()[surface].places(&self.placed_at_trial(body), |place, found| {
            if place == feature {
                normal = found.normal;
            }
        });
        normal
    }
}
