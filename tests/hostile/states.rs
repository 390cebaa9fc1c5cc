//! Mutated states and checkpoints.

use super::archives;
use super::mutants::{Fate, each};
use relcp::Scene;
use relcp::record::{Totals, decode, encode, encode_with_forces, state_hash};
use relcp::simulation::Simulation;
use relcp::step::contacts;

/// A state with near pairs, as a checkpoint, with the forces, and without.
pub fn files() -> Vec<Vec<u8>> {
    let stepped = |sets: &[String]| {
        let scene = Scene::load("three-capsules", sets).unwrap();
        let mut simulation = Simulation::new(scene).unwrap();
        for _ in 0..3 {
            simulation.step().unwrap();
        }
        simulation.state().unwrap().clone()
    };
    let (state, hash) = (&stepped(&[]), "0123456789abcdef");
    let periodic = &stepped(&["periodic={\"lengths\":[9,null,10]}".into()]);
    assert!(!state.warm.is_empty() && !periodic.bodies.periods.is_none());
    vec![
        encode(periodic, hash, 0.3, Some(&Totals::default())).unwrap(),
        encode(state, hash, 0.3, Some(&Totals::default())).unwrap(),
        encode_with_forces(state, hash, 0.3).unwrap(),
        encode(state, hash, 0.3, None).unwrap(),
    ]
}

/// What is read is as long as it says, and comes back.
pub fn fate(bytes: &[u8]) -> Fate {
    let (header, state) = match decode(bytes) {
        Ok(read) => read,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return Fate::Refused;
        }
    };
    let bodies = &state.bodies;
    assert_eq!(bodies.len() as u64, header.bodies);
    assert!([bodies.position.len(), bodies.orientation.len(), bodies.lineage.len()].iter().all(|n| *n == bodies.len()));
    let again = encode(&state, &header.scene, header.time, header.totals.as_ref()).unwrap();
    if let Ok((_, again)) = decode(&again) {
        assert_eq!(state_hash(&again), state_hash(&state));
        let _near = contacts(bodies, 0.01);
        return Fate::Made;
    }
    Fate::Read
}

#[test]
fn mutated_states_are_read_or_refused() {
    let files = files();
    for file in &files {
        assert!(fate(file) == Fate::Made);
        let mut sealed = file.clone();
        archives::seal(&mut sealed);
        assert!(&sealed == file, "the seal is that of the program");
    }
    let tally = each((1, "states"), &files, |random, file| archives::mutate(random, file), fate);
    assert!(tally.made > tally.refused / 20 && tally.refused > tally.made / 20, "{tally:?}");
}
