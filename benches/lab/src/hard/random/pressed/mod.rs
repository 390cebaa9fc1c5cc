//! Bodies that are pressed in narrow spaces: chambers that cells grow out of, closing walls, rows of bodies in line
//! between them, thin discs, and tubes as wide as the bodies in them.
//!
//! A step drives bodies by a small fraction of their size. So a body that contact moves by its length is thrown.

mod closing;
mod discs;
mod growing;
mod parts;
mod rows;
mod tubes;

use super::{Drawn, draw};
use crate::hard::start::Random;
use relcp::scene::SceneError;

/// Streams of pressed bodies come after those of confined colonies.
const FIRST_STREAM: u64 = 1 << 33;

/// Pressed bodies `number` of a seed.
///
/// ```
/// use relcp_lab::hard::random::pressed;
/// assert_eq!(pressed(1, 3)?.scene.name, "pressed-1-3");
/// # Ok::<(), relcp::scene::SceneError>(())
/// ```
///
/// # Errors
/// As [`random`](super::random()).
pub fn pressed(seed: u64, number: u64) -> Result<Drawn, SceneError> {
    let name = format!("pressed-{seed}-{number}");
    draw(Random::of_stream(seed, FIRST_STREAM + number), |random| attempt(random, &name))
}

fn attempt(random: &mut Random, name: &str) -> Drawn {
    match random.below(6) {
        0 => growing::draw(random, name),
        1 => closing::draw(random, name),
        2 | 3 => rows::draw(random, name),
        4 => discs::draw(random, name),
        _ => tubes::draw(random, name),
    }
}
