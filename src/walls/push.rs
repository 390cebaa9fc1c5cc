//! The forces of bodies on walls: the multipliers that a step ended with, where they act.

use super::{Walls, surface_of};
use crate::bodies::Bodies;
use crate::warm::Warm;
use glam::DVec3;

/// The force of a body on a surface of a wall at one of the places where it touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WallPush {
    /// The body's row.
    pub body: usize,
    /// The surface's place among those of all walls.
    pub surface: usize,
    /// The normal force.
    pub gamma: f64,
    /// The force on the wall: along the normal, and friction.
    pub force: DVec3,
    /// Where it acts: a point of the body's surface.
    pub point: DVec3,
}

impl Walls {
    /// The forces on these walls, in the order of `warm`, which is what the step that left `bodies` remembers of smooth
    /// surfaces. Normals and points are those of the accepted state.
    pub(crate) fn pushes<'a>(
        &'a self,
        bodies: &'a Bodies,
        warm: &'a [Warm],
    ) -> impl Iterator<Item = WallPush> + use<'a> {
        warm.iter().filter(|warm| warm.gamma > 0.0).filter_map(|warm| {
            let (body, surface) = (warm.pair[0] as usize, surface_of(warm.pair[1])?);
            let (placed, mut there) = (bodies.placed(body), None);
            self.surfaces.get(surface)?.places(&placed, |place, found| {
                if place == warm.feature {
                    there = Some(found);
                }
            });
            there.map(|found| WallPush {
                body,
                surface,
                gamma: warm.gamma,
                force: warm.force(found.normal),
                point: placed.position + found.lever_a,
            })
        })
    }
}
