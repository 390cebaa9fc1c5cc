//! Walls under a load in a step: each is one more body of the step's LCP, with one unknown, its velocity along its
//! normal.

use super::setup::Setup;
use super::start::Start;
use crate::constraint::{self, FIXED, Mover};
use crate::dynamics::{Ending, Factor, Motion, Root, Twist};
use crate::separation::Surface;
use crate::walls::{WallState, Walls};
use glam::{DMat3, DVec3};

/// A wall under a load.
pub(super) struct LoadedWall {
    surface: usize,
    normal: DVec3,
    /// Where it is at the start.
    before: WallState,
    motion: Motion,
    /// How far it has gone by the end of the present part: without contact until there is a trial.
    shift: f64,
    /// A point of it at the end of the part, had it not gone.
    point: DVec3,
}

impl LoadedWall {
    /// Its part in a row that was made where it is now.
    pub(super) fn mover(&self, interval: f64) -> Mover<'_> {
        if interval == 0.0 {
            return FIXED;
        }
        let linear = (self.shift - self.before.shift) / interval * self.normal;
        Mover { motion: &self.motion, reached_with: Twist { linear, angular: DVec3::ZERO }, axis: None }
    }

    /// Moves its surface to where it is.
    fn place(&self, walls: &mut Walls) {
        walls.set(self.surface, Surface::Plane { point: self.point + self.shift * self.normal, normal: self.normal });
    }
}

impl Start {
    /// Finds how loads move walls in the present part. Bodies that are parted move none.
    pub(super) fn load_walls(&mut self, setup: &Setup) {
        self.loaded.clear();
        let Some([before, end, middle]) = self.walls.as_mut().filter(|_| !setup.walls.loaded().is_empty()) else {
            return;
        };
        for (loaded, state) in setup.walls.loaded().iter().zip(&self.bodies.walls) {
            let [free, mobility] = loaded.moves(*state, self.interval);
            let (free, mobility) = if self.parting { (0.0, 0.0) } else { (free, mobility) };
            let normal = loaded.normal;
            let root = mobility.sqrt() * DMat3::from_cols(normal.x * normal, normal.y * normal, normal.z * normal);
            let motion = Motion {
                free: Twist { linear: free * normal, angular: DVec3::ZERO },
                factor: Factor { translation: Root::Axes(root), rotation: DMat3::ZERO },
                ending: Ending::default(),
            };
            let Some(Surface::Plane { point, .. }) = end.surfaces().get(loaded.surface).copied() else { continue };
            let shift = if self.parting { state.shift } else { state.shift + self.interval * free };
            let wall = LoadedWall { surface: loaded.surface, normal, before: *state, motion, shift, point };
            wall.place(end);
            self.loaded.push(wall);
        }
        for walls in [before, middle] {
            *walls = std::mem::take(walls).gone(&self.bodies.walls);
        }
    }

    /// The wall under a load that a surface is of.
    pub(super) fn loaded_wall(&self, surface: usize) -> Option<&LoadedWall> {
        self.loaded.iter().find(|wall| wall.surface == surface)
    }

    /// Moves walls under a load to the trial with these scaled velocities, those of bodies first.
    pub(super) fn press<const D: usize>(&mut self, scaled: &[[f64; D]]) {
        let (bodies, interval) = (self.bodies.len(), self.interval);
        let Some([_, end, _]) = self.walls.as_mut().filter(|_| !self.parting) else { return };
        for wall in &mut self.loaded {
            if let Some(scaled) = scaled.get(bodies + wall.surface) {
                let velocity = constraint::velocity(&wall.motion, scaled, interval).linear.dot(wall.normal);
                wall.shift = wall.before.shift + interval * velocity;
                wall.place(end);
            }
        }
    }

    /// Stores where walls under a load have come to.
    pub(super) fn leave_walls(&self, states: &mut [WallState]) {
        if self.parting {
            return;
        }
        for (state, wall) in states.iter_mut().zip(&self.loaded) {
            let velocity = (wall.shift - wall.before.shift) / self.interval;
            *state = WallState { shift: wall.shift, velocity };
        }
    }
}
