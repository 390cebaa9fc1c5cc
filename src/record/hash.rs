//! The hashes of states and scenes.

use super::blocks::body_blocks;
use super::fnv::Fnv;
use super::npz::{Block, Data};
use crate::scene::Scene;
use crate::step::State;

/// The hash of a state: its step, its next id and every bit of its bodies. Two runs with the same hash have the same
/// state file.
///
/// ```
/// use relcp::record::state_hash;
/// use relcp::step::State;
/// let start = State::default();
/// assert_eq!(state_hash(&start), state_hash(&start.clone()));
/// assert_ne!(state_hash(&start), state_hash(&State { step: 1, ..start }));
/// ```
pub fn state_hash(state: &State) -> String {
    let mut hash = Fnv::default();
    hash.update(&state.step.to_le_bytes());
    hash.update(&state.next_id.to_le_bytes());
    for Block { name, data, .. } in body_blocks(&state.bodies) {
        hash.update(name.as_bytes());
        match data {
            Data::F64(values) => values.iter().for_each(|v| hash.update(&v.to_le_bytes())),
            Data::U64(values) => values.iter().for_each(|v| hash.update(&v.to_le_bytes())),
            Data::U32(values) => values.iter().for_each(|v| hash.update(&v.to_le_bytes())),
            Data::I64(values) => values.iter().for_each(|v| hash.update(&v.to_le_bytes())),
            Data::I32(values) => values.iter().for_each(|v| hash.update(&v.to_le_bytes())),
        }
    }
    hash.hex()
}

/// The hash of a scene with every default written out: a scene and the `scene.json` of its run have the same hash.
pub fn scene_hash(scene: &Scene) -> String {
    let mut hash = Fnv::default();
    hash.update(scene.with_defaults().to_json().as_bytes());
    hash.hex()
}
