//! What of a step concerns walls: which bodies are near them, and which reach past them.

use super::LEAST_BODIES_A_TASK;
use super::narrow_phase::Near;
use crate::separation::{Placed, Separation};
use crate::shape::ProxySphere;
use crate::walls::{Walls, number_of, surface_of};
use glam::DVec3;
use rayon::prelude::*;

/// The places of all bodies whose gap to a surface is at most `limit(body)`, in the order of bodies, surfaces and
/// places.
pub(super) fn near(
    walls: &Walls,
    bodies: usize,
    placed: impl Fn(usize) -> Placed + Sync,
    limit: impl Fn(usize) -> f64 + Sync,
) -> Vec<Near> {
    along(walls, bodies, placed, limit, |placed, _, surface, found| walls.surfaces()[surface].places(placed, found))
}

/// The sub-spheres of all bodies, likewise.
pub(super) fn near_sub_spheres(
    walls: &Walls,
    proxies: &[Vec<ProxySphere>],
    placed: impl Fn(usize) -> Placed + Sync,
    limit: impl Fn(usize) -> f64 + Sync,
) -> Vec<Near> {
    along(walls, proxies.len(), placed, limit, |placed, body, surface, found| {
        gaps(walls, &proxies[body], placed, surface, found)
    })
}

/// Calls `found` with the gap of each sub-sphere of a body.
fn gaps(
    walls: &Walls,
    proxies: &[ProxySphere],
    placed: &Placed,
    surface: usize,
    found: &mut dyn FnMut(u32, Separation),
) {
    for (sphere, number) in proxies.iter().zip(0..) {
        let arm = placed.orientation * sphere.centre;
        found(number, walls.surfaces()[surface].at(placed.position, arm, sphere.radius));
    }
}

fn along(
    walls: &Walls,
    bodies: usize,
    placed: impl Fn(usize) -> Placed + Sync,
    limit: impl Fn(usize) -> f64 + Sync,
    places: impl Fn(&Placed, usize, usize, &mut dyn FnMut(u32, Separation)) + Sync,
) -> Vec<Near> {
    if walls.is_empty() {
        return Vec::new();
    }
    let of_body = |body: usize| {
        let (placed, limit) = (placed(body), limit(body));
        let mut near = Vec::new();
        for (surface, at) in walls.surfaces().iter().enumerate() {
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
    (0..bodies).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).flat_map_iter(of_body).collect()
}

/// Gives places that were found at walls at a step's end the normals and levers of the same places at the walls in its
/// middle, where forces act: their gaps stay those to the walls at the end.
pub(super) fn turn_to(middle: &Walls, near: &mut [Near], placed: impl Fn(usize) -> Placed + Sync) {
    turn(near, |near, surface, found| {
        let feature = near.feature;
        middle.surfaces()[surface].places(&placed(near.pair[0] as usize), |place, there| {
            if place == feature {
                *found = Some(there);
            }
        });
    });
}

/// The same of sub-spheres.
pub(super) fn turn_sub_spheres_to(
    middle: &Walls,
    proxies: &[Vec<ProxySphere>],
    near: &mut [Near],
    placed: impl Fn(usize) -> Placed + Sync,
) {
    turn(near, |near, surface, found| {
        let body = near.pair[0] as usize;
        let (sphere, placed) = (&proxies[body][near.feature as usize], placed(body));
        *found =
            Some(middle.surfaces()[surface].at(placed.position, placed.orientation * sphere.centre, sphere.radius));
    });
}

fn turn(near: &mut [Near], there: impl Fn(&Near, usize, &mut Option<Separation>) + Sync) {
    near.par_iter_mut().with_min_len(LEAST_BODIES_A_TASK).for_each(|near| {
        let (mut found, Some(surface)) = (None, surface_of(near.pair[1])) else { return };
        there(near, surface, &mut found);
        if let Some(found) = found {
            near.found = Separation { separation: near.found.separation, ..found };
        }
    });
}

/// The deepest that a sub-sphere of a body reaches past a surface.
pub(super) fn past_wall(walls: &Walls, proxies: &[ProxySphere], placed: &Placed, surface: usize) -> f64 {
    let mut deepest = 0.0_f64;
    gaps(walls, proxies, placed, surface, &mut |_, found| deepest = deepest.max(-found.separation));
    deepest
}

/// The normal at a place of a body towards a surface; zero where the body has no such place.
pub(super) fn normal_at(walls: &Walls, placed: &Placed, surface: usize, feature: u32) -> DVec3 {
    let mut normal = DVec3::ZERO;
    walls.surfaces()[surface].places(placed, |place, found| {
        if place == feature {
            normal = found.normal;
        }
    });
    normal
}
