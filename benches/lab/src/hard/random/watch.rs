//! What is looked at in every step of a drawn scene beside contact: how far bodies are thrown, and whether energy comes
//! from nowhere.

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

/// A body is clearly thrown where it goes so many lengths of the longest body farther than what drives it explains.
const THROWN: f64 = 10.0;
/// Energy clearly comes from nowhere where it is so many times what was there.
const CREATED: f64 = 1.0;
/// What is pressed is driven by a small part of its size in each step: contact that moves a body by its length throws
/// it.
const JUMPED: f64 = 1.0;

/// The worst of a run so far.
pub(super) struct Watch {
    free: Free,
    thrown: Option<f64>,
    /// The farthest that contact moved a body; none where it is not looked at.
    jumped: Option<f64>,
    energy: Option<Energy>,
}

impl Watch {
    pub(super) fn new(from: From, scene: &Scene) -> Watch {
        let jumped = (from == From::Pressed).then_some(0.0);
        Watch { free: Free::of(scene), thrown: None, jumped, energy: Energy::of(scene) }
    }

    /// Looks at a step: the bodies before it, and the simulation after it.
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

    /// How much farther a body went than what drives it explains: each body may push the next by the largest free way,
    /// the largest overlap at the start and the growth, so the last of a row goes by as many of those as there are
    /// bodies.
    fn see_ways(&mut self, before: &Bodies, after: &Bodies, scene: &Scene) {
        let dt = scene.time.dt;
        let free = self.free.way(before) + self.free.walls_way(before);
        let overlap = contacts(before, 0.0).iter().map(|contact| -contact.separation).fold(0.0, f64::max);
        let longest = after.shape.iter().chain(&before.shape).map(|shape| shape.major_axis()).fold(0.0, f64::max);
        let growth = scene.growth.iter().map(|growth| growth.fastest_rate() * dt * longest).fold(0.0, f64::max);
        // Daughters are turned, and stand a quarter of their mother's length beside her centre.
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

/// The farthest that a body went that stays, beyond the free way of any body and of walls, in lengths of the longest.
fn jump(free: &Free, before: &Bodies, after: &Bodies) -> f64 {
    let longest = after.shape.iter().map(|shape| shape.major_axis()).fold(0.0, f64::max);
    let driven = free.way(before) + free.turn(before) + free.walls_way(before);
    if after.is_empty() { 0.0 } else { (farthest(before, after).0 - driven) / longest }
}
