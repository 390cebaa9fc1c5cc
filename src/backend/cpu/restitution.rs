//! Restitution (Newton's): first contacts that close in the step part with a part of the speed that they came with.
//!
//! With the normal velocity `v-` of the state at the step's start, the gap `Phi` there and the coefficient `rho`, the
//! offset of the normal row of a contact with `v- < 0` and `Phi + dt v- <= 0` falls by `Phi + rho dt |v-|`, so that
//! `g >= 0` is `v+ >= rho |v-|`. A body at rest has `v- = 0`: no threshold of velocity is needed. Contacts that are
//! found at trials have none.
//!
//! Several contacts at once, or friction, can make energy of it (C. Glocker, Multibody Syst. Dyn. 29, 77 (2013)). A
//! step whose contacts add energy is taken again without restitution.

use super::narrow_phase::Near;
use super::setup::Setup;
use super::start::Start;
use crate::walls::surface_of;
use glam::DVec3;

/// How far a contact that bounces is to part in the step, a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounce {
    pub(super) pair: [u32; 2],
    pub(super) feature: u32,
    pub(super) apart: f64,
}

impl Setup {
    /// The coefficient of restitution of a pair.
    fn bounces(&self, [_, b]: [u32; 2]) -> f64 {
        if surface_of(b).is_some() { self.restitution.walls } else { self.restitution.bodies }
    }
}

impl Start {
    /// How a first contact bounces, if it does.
    pub(super) fn bounce(&self, setup: &Setup, near: &Near) -> Option<Bounce> {
        let rho = setup.bounces(near.pair);
        if rho == 0.0 || self.parting || self.without_restitution {
            return None;
        }
        let ([a, b], found) = (near.pair, &near.found);
        let velocity = |body: u32, lever: DVec3| {
            let twist = self.bodies.twist(body as usize);
            twist.linear + twist.angular.cross(lever)
        };
        let (of_b, gap) = match surface_of(b) {
            Some(surface) => {
                let point = self.bodies.position[a as usize] + found.lever_a + found.separation * found.normal;
                let wall = self.walls(setup).velocity(surface, point, self.span());
                (wall, found.separation - self.interval * found.normal.dot(wall))
            }
            None => {
                let image = self.image_velocity(setup, a as usize, b as usize);
                let places = near.pair.map(|body| self.bodies.position[body as usize]);
                (velocity(b, found.lever_b) + image, self.separation_before(setup, places, found))
            }
        };
        let approach = -found.normal.dot(of_b - velocity(a, found.lever_a));
        let closes = approach > 0.0 && gap <= self.interval * approach;
        let apart = gap + rho * self.interval * approach;
        (closes && apart > 0.0).then_some(Bounce { pair: near.pair, feature: near.feature, apart })
    }
}
