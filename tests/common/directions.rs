//! Random orientations and directions.

use glam::{DQuat, DVec3, DVec4};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

pub fn turn(random: &mut ChaCha8Rng) -> DQuat {
    loop {
        let v = DVec4::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        if (0.01..1.0).contains(&v.length_squared()) {
            return DQuat::from_vec4(v.normalize());
        }
    }
}

pub fn direction(random: &mut ChaCha8Rng) -> DVec3 {
    turn(random) * DVec3::Z
}
