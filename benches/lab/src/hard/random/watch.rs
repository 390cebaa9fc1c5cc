//! Checks of every step of a drawn scene in addition to contact: how far bodies are thrown, and whether energy is
//! created.

use super::From;
use crate::hard::Measure;
use crate::hard::energy::Energy;
use crate::hard::moves::{Free, born, farthest, worse};
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::Scene;
use relcp::simulation::Simulation;
use relcp::step::contacts;
use std::collections::HashMap;

/// A body counts as thrown if it moves farther than its drive explains by this many lengths of the longest body.
const THROWN: f64 = 10.0;
/// Energy counts as created if the excess is this multiple of the energy before.
const CREATED: f64 = 1.0;
/// Pressed bodies are driven by a small fraction of their size in each step, so contact that moves a body by its length
/// throws it.
const JUMPED: f64 = 1.0;

/// The worst of a run so far.
pub(super) struct Watch {
    free: Free,
    thrown: Option<f64>,
    /// The largest distance that contact moved a body; `None` if it is not checked.
    jumped: Option<f64>,
    energy: Option<Energy>,
}

impl Watch {
    pub(super) fn new(from: From, scene: &Scene) -> Watch {
        let jumped = (from == From::Pressed).then_some(0.0);
        Watch { free: Free::of(scene), thrown: None, jumped, energy: Energy::of(scene) }
    }

    /// Checks a step, from the bodies before it and the simulation after it.
    pub(super) fn see(&mut self, before: &Bodies, simulation: &Simulation) {
        let Ok(state) = simulation.state() else { return };
        let scene = simulation.scene();
        if !scene.dynamics.has_inertia() {
            self.see_ways(before, &state.bodies, scene);
        }
        if let Some(jumped) = &mut self.jumped {
            *jumped = worse(*jumped, jump(&self.free, before, &state.bodies));
        }
        if let Some(energy) = &mut self.energy {
            energy.see(before, &state.bodies, scene);
        }
    }

    /// Computes how much farther a body moved than its drive explains. Each body may push the next by the largest free
    /// path, the largest overlap at the start and the growth, so the last of a row goes by as many of those as there
    /// are bodies.
    fn see_ways(&mut self, before: &Bodies, after: &Bodies, scene: &Scene) {
        let dt = scene.time.dt;
        let shifts = before.walls.iter().zip(&after.walls).map(|(before, after)| (after.shift - before.shift).abs());
        let free = self.free.way(before) + self.free.walls_way(before) + shifts.fold(0.0, f64::max);
        let overlap = contacts(before, 0.0).iter().map(|contact| -contact.separation).fold(0.0, f64::max);
        let longest = after.shape.iter().chain(&before.shape).map(|shape| shape.major_axis()).fold(0.0, f64::max);
        let growth = scene.growth.iter().map(|growth| growth.fastest_rate() * dt * longest).fold(0.0, f64::max);
        // Daughters are turned, and their centres are a quarter of the mother's length away from hers.
        let division = if born(before, after) > 0 { longest } else { 0.0 };
        let explained = after.len() as f64 * (free + overlap + growth + division) + scene.contact.overlap_tolerance;
        let old: HashMap<u64, DVec3> =
            before.lineage.iter().zip(&before.position).map(|(line, x)| (line.id, *x)).collect();
        let from = |i: usize| {
            let line = &after.lineage[i];
            old.get(&line.id).or_else(|| line.parent.and_then(|parent| old.get(&parent)))
        };
        let way = |i: usize| from(i).map_or(0.0, |x| (after.position[i] - *x).length());
        let farthest = (0..after.len()).map(way).fold(0.0, worse);
        let beyond = (farthest - explained) / longest;
        self.thrown = Some(self.thrown.map_or(beyond, |worst| worse(worst, beyond)));
    }

    pub(super) fn measures(&self) -> Vec<Measure> {
        let mut out = Vec::new();
        if let Some(value) = self.thrown {
            let what = "way of a body in a step beyond what drives it, in lengths of the longest";
            out.push(Measure { what, value, bound: THROWN, by_passing: false });
        }
        if let Some(value) = self.jumped {
            let what = "move of a body by contact in a step, in lengths of the longest";
            out.push(Measure { what, value, bound: JUMPED, by_passing: false });
        }
        if let Some(value) = self.energy.as_ref().and_then(Energy::gain) {
            let what = "energy from nowhere, of the most energy of motion before it";
            out.push(Measure { what, value, bound: CREATED, by_passing: false });
        }
        out
    }
}

/// Returns the largest distance that a surviving body moved beyond the largest free path of any body and of walls, in
/// lengths of the longest body.
fn jump(free: &Free, before: &Bodies, after: &Bodies) -> f64 {
    let longest = after.shape.iter().map(|shape| shape.major_axis()).fold(0.0, f64::max);
    let driven = free.way(before) + free.turn(before) + free.walls_way(before);
    if after.is_empty() { 0.0 } else { (farthest(before, after).0 - driven) / longest }
}
