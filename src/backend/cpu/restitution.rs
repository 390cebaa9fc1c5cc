//! Restitution (Newton's): first contacts that close in the step part with a part of the speed that they came with.
//!
//! With the normal velocity `v-` of approach, the gap `Phi` at the step's start and the coefficient `rho`, the offset
//! of the normal row of a contact with `v- < 0` and `Phi + dt v- <= 0` falls by `Phi + rho dt |v-|`, so that `g >= 0`
//! is `v+ >= rho |v-|`. `v-` is the velocity of the state at the step's start, or the free one at its end where that
//! approaches more slowly, as against gravity or drag: more than the free velocity would make energy. A body at rest
//! has `v- = 0`: no threshold of velocity is needed. Brownian bodies have the free velocity, with the step's random
//! part: contact that turned back another one would take heat. Contacts that are found at trials have none.
//!
//! Several contacts at once, or friction, can make energy of it (C. Glocker, Multibody Syst. Dyn. 29, 77 (2013)). A
//! step whose contacts add energy is taken again without restitution.

use super::motions::Motions;
use super::narrow_phase::Near;
use super::row_set::Bounce;
use super::setup::Setup;
use super::start::Start;
use crate::dynamics::Twist;
use crate::walls::surface_of;
use glam::DVec3;

impl Setup {
    /// The coefficient of restitution of a pair.
    fn bounces(&self, [_, b]: [u32; 2]) -> f64 {
        if surface_of(b).is_some() { self.restitution.walls } else { self.restitution.bodies }
    }
}

impl Start {
    /// How a first contact bounces, if it does.
    pub(super) fn bounce(&self, setup: &Setup, motions: &Motions, near: &Near) -> Option<Bounce> {
        let rho = setup.bounces(near.pair);
        if rho == 0.0 || self.parting || self.without_restitution {
            return None;
        }
        let free = self.approach(setup, near, |body| motions.motion[body].free);
        let approach = match setup.heat {
            Some(_) => free,
            None => free.min(self.approach(setup, near, |body| self.bodies.twist(body))),
        };
        let gap = match surface_of(near.pair[1]) {
            Some(_) => near.found.separation - self.interval * near.found.normal.dot(self.wall_velocity(setup, near)),
            None => {
                let places = near.pair.map(|body| self.bodies.position[body as usize]);
                self.separation_before(setup, places, &near.found)
            }
        };
        let closes = approach > 0.0 && gap <= self.interval * approach;
        let apart = gap + rho * self.interval * approach;
        (closes && apart > 0.0).then_some(Bounce { pair: near.pair, feature: near.feature, apart })
    }

    /// The speed at which the points of a contact approach each other, with these velocities of bodies.
    fn approach(&self, setup: &Setup, near: &Near, twist_of: impl Fn(usize) -> Twist) -> f64 {
        let ([a, b], found) = (near.pair.map(|number| number as usize), &near.found);
        let velocity = |body: usize, lever: DVec3| {
            let twist = twist_of(body);
            twist.linear + twist.angular.cross(lever)
        };
        let of_b = match surface_of(near.pair[1]) {
            Some(_) => self.wall_velocity(setup, near),
            None => velocity(b, found.lever_b) + self.image_velocity(setup, a, b),
        };
        -found.normal.dot(of_b - velocity(a, found.lever_a))
    }

    /// The velocity of the surface that a body is near; zero between bodies.
    fn wall_velocity(&self, setup: &Setup, near: &Near) -> DVec3 {
        let ([a, b], found) = (near.pair, &near.found);
        surface_of(b).map_or(DVec3::ZERO, |surface| {
            let point = self.bodies.position[a as usize] + found.lever_a + found.separation * found.normal;
            self.walls(setup).velocity(surface, point, self.span())
        })
    }
}
