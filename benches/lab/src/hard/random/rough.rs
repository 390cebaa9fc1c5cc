//! Friction and restitution for drawn scenes, from a stream of their own, so that the scenes stay what they are.

use super::Drawn;
use crate::hard::start::Random;
use relcp::scene::{Dynamics, Friction, OnFailure, Restitution, SolverKind, Stepping};
use std::fmt::Write as _;

/// What this stream's seed differs by from that of the scenes.
const OWN_SEED: u64 = 0x726f_7567_6800;
/// Coefficients of friction: those of most materials, and in one of five scenes larger ones.
const FRICTION: [f64; 2] = [0.05, 1.0];
const MORE: [f64; 2] = [1.0, 4.0];

/// Gives a scene friction, and in some scenes with inertia restitution. Settings that do not support them give way.
pub(super) fn roughen(seed: u64, number: u64, drawn: &mut Drawn) {
    let mut random = Random::of_stream(seed ^ OWN_SEED, number);
    let scene = &mut drawn.scene;
    let [low, high] = if random.chance(0.8) { FRICTION } else { MORE };
    let coefficient = random.log_within(low, high);
    scene.contact.friction = Friction::of_all(coefficient);
    if random.chance(0.3) {
        scene.contact.friction.walls = random.within(0.0, high);
    }
    let _ = write!(drawn.what, ", friction {coefficient:.2}");
    if matches!(scene.dynamics, Dynamics::Inertial { .. }) && random.chance(0.3) {
        let restitution = random.within(0.0, 1.0);
        scene.contact.restitution = Restitution::of_all(restitution);
        let _ = write!(drawn.what, ", restitution {restitution:.2}");
    }
    scene.time.stepping = Stepping::Euler;
    scene.contact.on_failure = OnFailure::Stop;
    if !scene.solver.kind.supports_friction() {
        scene.solver.kind = SolverKind::Auto;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hard::random::random;

    #[test]
    fn every_drawn_scene_may_have_friction() {
        let mut bounce = 0;
        for number in 0..60 {
            let mut drawn = random(5, number).unwrap();
            let bodies = drawn.scene.bodies.clone();
            roughen(5, number, &mut drawn);
            drawn.scene.validate().unwrap();
            assert!(drawn.scene.bodies == bodies && !drawn.scene.contact.friction.is_none());
            bounce += usize::from(!drawn.scene.contact.restitution.is_none());
        }
        assert!(bounce > 3, "{bounce}");
    }
}
