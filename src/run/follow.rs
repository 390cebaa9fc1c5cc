//! The processes of a run that follow rank 0: they write nothing, and take the steps that it says.

use crate::processes::Processes;
use crate::record::{decode, encode_with_forces, scene_hash};
use crate::scene::Scene;
use crate::simulation::{Compute, Said, Simulation, Together};
use crate::step::State;

/// What computes a run that processes take together.
pub fn together(processes: Processes) -> Together {
    Together::new(processes, pack)
}

/// Follows rank 0 to its end. A process that cannot do what rank 0 says gives its reason to `complain` and ends
/// them all with `status`, since the others would wait for it for ever.
pub fn follow(processes: Processes, status: u8, complain: impl Fn(&str)) {
    let together = together(processes);
    let mut simulation: Option<Simulation> = None;
    let cannot = |what: &str| -> ! {
        complain(&format!("process {} cannot go on: {what}", processes.rank()));
        processes.abort(status)
    };
    loop {
        match together.hear() {
            Said::End => return,
            Said::Start(packed) => {
                let (scene, state) = unpack(&packed).unwrap_or_else(|what| cannot(&what));
                // What it refuses rank 0 refuses too, and says so.
                simulation = Simulation::start(&Compute::Together(together), scene, state).ok();
            }
            Said::StartWithAPart(packed, numbers) => {
                let (scene, state) = unpack(&packed).unwrap_or_else(|what| cannot(&what));
                simulation = Simulation::start_with_a_part(together, scene, state, numbers).ok();
            }
            Said::Gather => match &simulation {
                Some(simulation) => drop(simulation.state()),
                None => cannot("it has no state to give"),
            },
            Said::Step => match &mut simulation {
                // A fault is rank 0's as well.
                Some(simulation) => drop(simulation.step()),
                None => cannot("it has no simulation to step"),
            },
        }
    }
}

/// The length of the scene's text, the text, the state as a file has it.
fn pack(scene: &Scene, state: &State) -> Result<Vec<u8>, String> {
    let text = scene.to_json();
    let state =
        encode_with_forces(state, &scene_hash(scene), scene.time.after(state.step)).map_err(|e| e.to_string())?;
    Ok([&(text.len() as u64).to_le_bytes(), text.as_bytes(), state.as_slice()].concat())
}

fn unpack(packed: &[u8]) -> Result<(Scene, State), String> {
    let cut = || "a message was cut".to_owned();
    let (length, rest) = packed.split_first_chunk().ok_or_else(cut)?;
    let (text, state) = rest.split_at_checked(u64::from_le_bytes(*length) as usize).ok_or_else(cut)?;
    let text = std::str::from_utf8(text).map_err(|e| e.to_string())?;
    let scene = Scene::parse(text, "the scene of rank 0").map_err(|e| e.to_string())?;
    let (header, state) = decode(state).map_err(|e| e.to_string())?;
    match header.scene == scene_hash(&scene) {
        true => Ok((scene, state)),
        false => Err("the scene of rank 0 did not arrive as it was sent".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::state_hash;

    #[test]
    fn a_scene_and_a_state_arrive_as_they_were_sent() {
        for name in ["colony", "chainmail", "two-ellipsoids"] {
            let scene = Scene::built_in(name).unwrap();
            let mut simulation = Simulation::new(scene.clone()).unwrap();
            simulation.step().unwrap();
            let state = simulation.state().unwrap();
            let (scene_there, state_there) = unpack(&pack(&scene, state).unwrap()).unwrap();
            assert_eq!(scene_hash(&scene_there), scene_hash(&scene));
            assert_eq!(state_hash(&state_there), state_hash(state));
            assert_eq!(state_there.warm, state.warm);
        }
        assert!(unpack(&[1, 2, 3]).is_err() && unpack(&[255; 40]).is_err());
    }
}
