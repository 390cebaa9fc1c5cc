//! A check for created energy: contact dissipates energy, and forces with a potential conserve it.

use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::{Dynamics, Force, Scene};
use relcp::step::contacts;

/// The energy of the bodies of a scene with inertia, step by step.
pub(super) struct Energy {
    density: f64,
    pulls: Vec<Pull>,
    account: Option<Account>,
}

/// A force whose potential is linear in space: an acceleration, or the same force on every body.
struct Pull {
    group: Option<u32>,
    along: DVec3,
    by_mass: bool,
}

struct Account {
    /// The least that there was.
    least: f64,
    /// The most energy of motion that was had honestly.
    scale: f64,
    gain: f64,
}

impl Energy {
    /// Returns the check if the energy of the scene is known: the scene has inertia, no growth, walls that stay, and
    /// forces with a linear potential only.
    pub(super) fn of(scene: &Scene) -> Option<Energy> {
        let Dynamics::Inertial { density, drag: None } = scene.dynamics else { return None };
        let groups = scene.group_names();
        let number = |name: &Option<String>| {
            let name = name.as_ref()?;
            groups.iter().position(|group| group == name).map(|index| index as u32)
        };
        let pull = |force: &Force| match force {
            Force::Uniform { force, group, window: None } => {
                Some(Pull { group: number(group), along: DVec3::from(*force), by_mass: false })
            }
            Force::Gravity { acceleration, group, window: None } => {
                Some(Pull { group: number(group), along: DVec3::from(*acceleration), by_mass: true })
            }
            _ => None,
        };
        let pulls = scene.forces.iter().map(pull).collect::<Option<Vec<Pull>>>()?;
        // Walls that move do work, and bodies that leave take theirs with them.
        let open = scene.walls.iter().any(|wall| wall.motion().is_some() || wall.load().is_some());
        let open = open || !scene.removal.is_empty();
        (scene.growth.is_empty() && !open).then_some(Energy { density, pulls, account: None })
    }

    /// Looks at a step. A start that overlaps is parted by the first step, from which on nothing may come.
    pub(super) fn see(&mut self, before: &Bodies, after: &Bodies, scene: &Scene) {
        let (now, kinetic) = self.total(after);
        let parting = self.parting(after, scene);
        let first = |energy: &Energy| {
            let apart = contacts(before, 0.0).is_empty() && scene.walls().max_overlap(before) == 0.0;
            let (start, moving) = if apart { energy.total(before) } else { (now, kinetic) };
            Account { least: start, scale: moving.max(parting), gain: 0.0 }
        };
        let mut account = self.account.take().unwrap_or_else(|| first(self));
        let rise = now - account.least;
        account.scale = account.scale.max(kinetic - rise.max(0.0));
        // The top of a stack is raised by as many tolerances as there are bodies below it.
        let beyond = rise - after.len() as f64 * parting;
        // Not `max`, which takes the other where one is not a number.
        let gain = if beyond < 0.0 { 0.0 } else { beyond / account.scale };
        if gain > account.gain || gain.is_nan() {
            account.gain = gain;
        }
        account.least = account.least.min(now);
        self.account = Some(account);
    }

    /// The most that there was more of than at any time before, of the most energy of motion that was had honestly.
    pub(super) fn gain(&self) -> Option<f64> {
        self.account.as_ref().map(|account| account.gain)
    }

    /// All energy, and that of motion alone.
    fn total(&self, bodies: &Bodies) -> (f64, f64) {
        let of = |i: usize| {
            let mass = self.density * bodies.shape[i].volume();
            let acts = |pull: &&Pull| pull.group.is_none_or(|group| bodies.group[i] == group);
            let work = |pull: &Pull| (if pull.by_mass { mass } else { 1.0 }) * pull.along.dot(bodies.position[i]);
            let moving = of_motion(bodies, i, self.density);
            (moving - self.pulls.iter().filter(acts).map(work).sum::<f64>(), moving)
        };
        (0..bodies.len()).map(of).fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
    }

    /// What comes of parting overlaps within the tolerance: each body is raised by it, in a step.
    fn parting(&self, bodies: &Bodies, scene: &Scene) -> f64 {
        let tolerance = scene.contact.overlap_tolerance;
        let of = |i: usize| {
            let mass = self.density * bodies.shape[i].volume();
            let force = |pull: &Pull| (if pull.by_mass { mass } else { 1.0 }) * pull.along.length();
            mass * (tolerance / scene.time.dt).powi(2) + tolerance * self.pulls.iter().map(force).sum::<f64>()
        };
        (0..bodies.len()).map(of).sum()
    }
}

/// A body's energy of motion.
pub(super) fn of_motion(bodies: &Bodies, i: usize, density: f64) -> f64 {
    let (shape, twist) = (bodies.shape[i], bodies.twist(i));
    let in_body = bodies.orientation[i].inverse() * twist.angular;
    let turning = (shape.unit_inertia() * in_body).dot(in_body);
    0.5 * density * (shape.volume() * twist.linear.length_squared() + turning)
}

/// A body's angular momentum about its centre, in space.
pub(super) fn turning(bodies: &Bodies, i: usize) -> DVec3 {
    let q = bodies.orientation[i];
    q * (bodies.shape[i].unit_inertia() * (q.inverse() * bodies.angular_velocity[i]))
}
