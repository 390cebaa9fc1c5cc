//! The ranks other than 0 of a run: they execute the commands of rank 0 and write nothing.

use crate::processes::Processes;
use crate::record::{decode, encode_with_forces, scene_hash};
use crate::scene::Scene;
use crate::simulation::{Command, Compute, Simulation, Together};
use crate::step::State;

/// Computes a run on several processes.
pub fn together(processes: Processes) -> Together {
    Together::new(processes, pack)
}

/// Executes the commands of rank 0 until it ends. If one fails here only, `complain` gets the reason and all processes
/// end with `status`: the others would wait forever.
pub fn follow(processes: Processes, status: u8, complain: impl Fn(&str)) {
    let together = together(processes);
    let mut simulation: Option<Simulation> = None;
    let cannot = |what: &str| -> ! {
        complain(&format!("rank {} cannot continue: {what}", processes.rank()));
        processes.abort(status)
    };
    loop {
        match together.receive() {
            Command::End => return,
            Command::Start(packed) => {
                let (scene, state) = unpack(&packed).unwrap_or_else(|what| cannot(&what));
                // Rank 0 gets the same error and reports it.
                simulation = Simulation::start(&Compute::Together(together), scene, state).ok();
            }
            Command::StartPart(packed, numbers) => {
                let (scene, state) = unpack(&packed).unwrap_or_else(|what| cannot(&what));
                simulation = Simulation::start_part(together, scene, state, numbers).ok();
            }
            Command::Gather => match &simulation {
                Some(simulation) => drop(simulation.state()),
                None => cannot("it has no state"),
            },
            Command::Step => match &mut simulation {
                // Rank 0 gets the same fault.
                Some(simulation) => drop(simulation.step()),
                None => cannot("it has no simulation"),
            },
        }
    }
}

/// The length of the scene's text, the text, and the encoded state.
fn pack(scene: &Scene, state: &State) -> Result<Vec<u8>, String> {
    let text = scene.to_json();
    let state =
        encode_with_forces(state, &scene_hash(scene), scene.time.after(state.step)).map_err(|e| e.to_string())?;
    Ok([&(text.len() as u64).to_le_bytes(), text.as_bytes(), state.as_slice()].concat())
}

fn unpack(packed: &[u8]) -> Result<(Scene, State), String> {
    let cut = || "a message is incomplete".to_owned();
    let (length, rest) = packed.split_first_chunk().ok_or_else(cut)?;
    let (text, state) = rest.split_at_checked(u64::from_le_bytes(*length) as usize).ok_or_else(cut)?;
    let text = std::str::from_utf8(text).map_err(|e| e.to_string())?;
    let scene = Scene::parse(text, "the scene of rank 0").map_err(|e| e.to_string())?;
    let (header, state) = decode(state).map_err(|e| e.to_string())?;
    match header.scene == scene_hash(&scene) {
        true => Ok((scene, state)),
        false => Err("the scene of rank 0 was received with errors".into()),
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
