//! What is looked at in every step of a drawn scene beside contact: how far bodies are thrown, and whether energy comes from nowhere.

use crate::bodies::Bodies;
use crate::dynamics::{ForceField, Law, forces_from_scene, law};
use crate::relcp::{Simulation, contacts};
use crate::scene::{Dynamics, Force, Scene};
use crate::study::hard::Measure;
use glam::DVec3;
use std::collections::HashMap;

/// A body is clearly thrown where it goes so many lengths of the longest body farther than what drives it explains.
const THROWN: f64 = 10.0;
/// Energy clearly comes from nowhere where it is so many times what was there.
const CREATED: f64 = 1.0;

/// The worst of a run so far.
pub(super) struct Watch {
    law: Box<dyn Law>,
    forces: Vec<Box<dyn ForceField>>,
    dynamics: Dynamics,
    /// Accelerations, or forces, that have a potential which is linear in space, by group; none where one has not.
    pulls: Option<Vec<Pull>>,
    thrown: f64,
    energy: Option<Energy>,
}

struct Pull {
    group: Option<u32>,
    along: DVec3,
    by_mass: bool,
}

struct Energy {
    /// The most that there may be.
    least: f64,
    /// What it is measured by.
    scale: f64,
    gain: f64,
    settled: bool,
}

impl Watch {
    pub(super) fn new(scene: &Scene) -> Watch {
        let groups = scene.group_names();
        let number = |name: &Option<String>| {
            name.as_ref().and_then(|name| groups.iter().position(|group| group == name)).map(|index| index as u32)
        };
        let pull = |force: &Force| match force {
            Force::Uniform { force, group } => {
                Some(Pull { group: number(group), along: DVec3::from(*force), by_mass: false })
            }
            Force::Gravity { acceleration, group } => {
                Some(Pull { group: number(group), along: DVec3::from(*acceleration), by_mass: true })
            }
            Force::RadialInward { .. } | Force::RadialOutward { .. } => None,
        };
        let inertial = matches!(scene.dynamics, Dynamics::Inertial { .. }) && scene.growth.is_none();
        Watch {
            law: law(&scene.dynamics),
            forces: forces_from_scene(&scene.forces, &groups, &scene.dynamics),
            dynamics: scene.dynamics,
            pulls: scene.forces.iter().map(pull).collect::<Option<Vec<Pull>>>().filter(|_| inertial),
            thrown: f64::NEG_INFINITY,
            energy: None,
        }
    }

    /// Looks at a step: the bodies before it, and the simulation after it.
    pub(super) fn see(&mut self, before: &Bodies, simulation: &Simulation) {
        let Ok(state) = simulation.state() else { return };
        match self.dynamics {
            Dynamics::Overdamped { .. } => self.see_ways(before, &state.bodies, simulation.scene()),
            Dynamics::Inertial { density } => self.see_energy(before, &state.bodies, density, simulation.scene()),
        }
    }

    /// How much farther a body went than what drives it explains: each body may push the next by the largest free way, the largest overlap at the
    /// start and the growth, so the last of a row goes by as many of those as there are bodies.
    fn see_ways(&mut self, before: &Bodies, after: &Bodies, scene: &Scene) {
        let (dt, time) = (scene.time.dt, 0.0);
        let free = |i: usize| {
            let load =
                self.forces.iter().map(|force| force.load(before, i, time)).fold(Default::default(), |a, b| a + b);
            dt * self.law.motion(before, i, load, dt).free.linear.length()
        };
        let free = (0..before.len()).map(free).fold(0.0, f64::max);
        let overlap = contacts(before, 0.0).iter().map(|(_, found)| -found.separation).fold(0.0, f64::max);
        let longest = after.shape.iter().chain(&before.shape).map(|shape| shape.major_axis()).fold(0.0, f64::max);
        let growth = scene.growth.map_or(0.0, |growth| growth.fastest_rate() * dt * longest);
        // Daughters are turned, and stand a quarter of their mother's length beside her centre.
        let division = if after.len() > before.len() { longest } else { 0.0 };
        let explained = after.len() as f64 * (free + overlap + growth + division) + scene.contact.overlap_tolerance;
        let old: HashMap<u64, DVec3> =
            before.lineage.iter().zip(&before.position).map(|(line, x)| (line.id, *x)).collect();
        let from = |i: usize| {
            let line = &after.lineage[i];
            old.get(&line.id).or_else(|| line.parent.and_then(|parent| old.get(&parent)))
        };
        let way = |i: usize| from(i).map_or(0.0, |x| (after.position[i] - *x).length());
        let farthest = (0..after.len()).map(way).fold(0.0, worse);
        self.thrown = worse(self.thrown, (farthest - explained) / longest);
    }

    /// What there is more of than at the start, or after a first step that parts what overlapped: contact takes energy, and forces of a linear
    /// potential give none.
    fn see_energy(&mut self, before: &Bodies, after: &Bodies, density: f64, scene: &Scene) {
        let Some(pulls) = &self.pulls else { return };
        let at = |bodies: &Bodies| -> [f64; 2] {
            let of = (0..bodies.len()).map(|i| energy(bodies, i, density, pulls));
            of.fold([0.0; 2], |[all, kinetic], [one, moving]| [all + one, kinetic + moving])
        };
        let [now, kinetic] = at(after);
        let least = scale(after, density, pulls, scene);
        let energy = self.energy.get_or_insert_with(|| {
            let [start, kinetic] = at(before);
            let scale = kinetic.max(least);
            Energy { least: start, scale, gain: 0.0, settled: contacts(before, 0.0).is_empty() }
        });
        if !energy.settled {
            *energy = Energy { least: now, scale: kinetic.max(least), gain: 0.0, settled: true };
        }
        // What has fallen moves: a gain is measured by the most energy of motion that was had honestly.
        let honest = energy.scale.max(kinetic - (now - energy.least).max(0.0));
        energy.scale = honest;
        energy.gain = worse(energy.gain, (now - energy.least) / honest);
        energy.least = if now < energy.least { now } else { energy.least };
    }

    pub(super) fn measures(&self) -> Vec<Measure> {
        let mut out = Vec::new();
        if self.thrown > f64::NEG_INFINITY || self.thrown.is_nan() {
            let what = "way of a body in a step beyond what drives it, in lengths of the longest";
            out.push(Measure { what, value: self.thrown, bound: THROWN, by_passing: false });
        }
        if let Some(energy) = &self.energy {
            let what = "energy from nowhere, of the most energy of motion before it";
            out.push(Measure { what, value: energy.gain, bound: CREATED, by_passing: false });
        }
        out
    }
}

/// The energy that comes of parting overlaps within the tolerance: each body is raised by it, in a step.
fn scale(bodies: &Bodies, density: f64, pulls: &[Pull], scene: &Scene) -> f64 {
    let tolerance = scene.contact.overlap_tolerance;
    let of = |i: usize| {
        let mass = density * bodies.shape[i].volume();
        let force = |pull: &Pull| (if pull.by_mass { mass } else { 1.0 }) * pull.along.length();
        mass * (tolerance / scene.time.dt).powi(2) + tolerance * pulls.iter().map(force).sum::<f64>()
    };
    (0..bodies.len()).map(of).sum()
}

/// A body's energy, and that of its motion alone.
fn energy(bodies: &Bodies, i: usize, density: f64, pulls: &[Pull]) -> [f64; 2] {
    let shape = bodies.shape[i];
    let mass = density * shape.volume();
    let twist = bodies.twist(i);
    let in_body = bodies.orientation[i].inverse() * twist.angular;
    let turning = density * (shape.unit_inertia() * in_body).dot(in_body);
    let kinetic = 0.5 * (mass * twist.linear.length_squared() + turning);
    let acts = |pull: &&Pull| pull.group.is_none_or(|group| bodies.group[i] == group);
    let work = |pull: &Pull| (if pull.by_mass { mass } else { 1.0 }) * pull.along.dot(bodies.position[i]);
    [kinetic - pulls.iter().filter(acts).map(work).sum::<f64>(), kinetic]
}

/// The larger, and what is not a number before all.
fn worse(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}
