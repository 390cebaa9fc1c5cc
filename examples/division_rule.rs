//! A colony that divides by a rule of one's own: a cell divides once it has added a length of 2 since its birth (an
//! adder), whatever it was born with, and its daughters share its length unevenly. Between two steps the state may be
//! changed at will.

use relcp::bodies::Lineage;
use relcp::glam::{DQuat, DVec3};
use relcp::{Scene, Shape, Simulation, State};
use std::collections::HashMap;

const ADDED: f64 = 2.0;
const CELLS: usize = 24;

fn main() -> Result<(), relcp::Error> {
    // Cells of the scene's own rule would divide at a length that none reaches.
    let scene = Scene::load("colony", ["time.end=10", "growth.division_length=100"])?;
    let mut simulation = Simulation::new(scene.clone())?;
    let mut born_with = HashMap::new();
    while !simulation.done() && simulation.state()?.bodies.len() < CELLS {
        let report = simulation.step()?;
        assert!(report.max_overlap <= 1e-5);
        let mut state = simulation.state()?.clone();
        let before = state.bodies.len();
        for cell in 0..before {
            let Shape::Spherocylinder { length, .. } = state.bodies.shape[cell] else { continue };
            let first = *born_with.entry(state.bodies.lineage[cell].id).or_insert(length);
            if length - first >= ADDED {
                divide(&mut state, cell, report.time);
            }
        }
        if state.bodies.len() > before {
            simulation = Simulation::builder(scene.clone()).resume(state).build()?;
        }
    }
    let bodies = &simulation.state()?.bodies;
    let generations: Vec<u32> = bodies.lineage.iter().map(|line| line.generation).collect();
    println!("{} cells at time {:.3}, of generations {generations:?}", bodies.len(), simulation.time());
    Ok(())
}

/// Cuts a rod in two whose lengths add up to its own, as 45 to 55, and bends them apart a little.
fn divide(state: &mut State, cell: usize, time: f64) {
    let bodies = &mut state.bodies;
    let (placed, line, group) = (bodies.placed(cell), bodies.lineage[cell], bodies.group[cell]);
    let Shape::Spherocylinder { diameter, length } = placed.shape else { return };
    let axis = placed.orientation * DVec3::Z;
    let other = bodies.push(placed, group);
    for (daughter, part, place) in [(cell, 0.45, -0.275), (other, 0.55, 0.225)] {
        bodies.shape[daughter] = Shape::Spherocylinder { diameter, length: part * length };
        bodies.position[daughter] = placed.position + place * length * axis;
        let turn = DQuat::from_rotation_z(0.02 * (part - 0.5));
        bodies.orientation[daughter] = (turn * placed.orientation).normalize();
        let generation = line.generation + 1;
        let (id, parent) = (state.next_id, Some(line.id));
        bodies.lineage[daughter] = Lineage { id, parent, birth: time, generation, birth_length: None };
        state.next_id += 1;
    }
}
