//! The distance that contact moves bodies in a step, beyond the motion of bodies and walls without contact.

use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::dynamics::ForceField;
use relcp::internals::dynamics::{Law, force_fields, law};
use relcp::internals::walls::reference;
use relcp::scene::{Scene, Wall};
use std::collections::HashMap;

/// The data for motion without contact: the law of motion and the forces.
pub(super) struct Free {
    law: Box<dyn Law>,
    inertial: bool,
    forces: Vec<Box<dyn ForceField>>,
    walls: Vec<Wall>,
    dt: f64,
}

impl Free {
    pub(super) fn of(scene: &Scene) -> Free {
        Free {
            law: law(&scene.dynamics),
            inertial: scene.dynamics.has_inertia(),
            forces: force_fields(&scene.forces, &scene.group_names(), &scene.dynamics),
            walls: scene.walls.clone(),
            dt: scene.time.dt,
        }
    }

    /// Returns the largest distance that the centre of a body would move in a step without contact.
    pub(super) fn way(&self, before: &Bodies) -> f64 {
        let free = |i: usize| {
            let load =
                self.forces.iter().map(|force| force.load(before, i, 0.0)).fold(Default::default(), |a, b| a + b);
            self.dt * self.law.motion(before, i, load, self.dt).free.linear.length()
        };
        (0..before.len()).map(free).fold(0.0, worse)
    }

    /// Returns the largest distance that the end of a body would move in a step by its rotation alone.
    pub(super) fn turn(&self, before: &Bodies) -> f64 {
        if !self.inertial {
            return 0.0;
        }
        let end = |i: usize| self.dt * before.angular_velocity[i].length() * before.shape[i].bounding_radius();
        (0..before.len()).map(end).fold(0.0, worse)
    }

    /// Returns the largest distance that a wall moves in a step; for a rotating wall, at a body.
    pub(super) fn walls_way(&self, before: &Bodies) -> f64 {
        let farthest = |about: DVec3| before.position.iter().map(|x| (*x - about).length()).fold(0.0, f64::max);
        let way = |wall: &Wall| {
            let motion = wall.motion()?;
            let turning = motion.angular_velocity.map_or(0.0, |turning| DVec3::from(turning).length());
            let arm = if turning > 0.0 { farthest(reference(wall)) } else { 0.0 };
            Some(self.dt * (DVec3::from(motion.velocity).length() + turning * arm))
        };
        self.walls.iter().filter_map(way).fold(0.0, f64::max)
    }
}

/// Returns the largest distance that the centre of a body moved, and the body's id. Only bodies that exist before and
/// after the step count.
pub(super) fn farthest(before: &Bodies, after: &Bodies) -> (f64, Option<u64>) {
    let old: HashMap<u64, DVec3> = before.lineage.iter().zip(&before.position).map(|(line, x)| (line.id, *x)).collect();
    let mut most = (0.0, None);
    for (line, x) in after.lineage.iter().zip(&after.position) {
        let way = old.get(&line.id).map_or(0.0, |from| (*x - *from).length());
        if way > most.0 || way.is_nan() {
            most = (way, Some(line.id));
        }
    }
    most
}

/// Returns the number of bodies after a step whose ids did not exist before it.
pub(super) fn born(before: &Bodies, after: &Bodies) -> usize {
    let old: std::collections::HashSet<u64> = before.lineage.iter().map(|line| line.id).collect();
    after.lineage.iter().filter(|line| !old.contains(&line.id)).count()
}

/// Returns the larger value. A NaN is larger than every number.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hard::start::{Start, moving, sphere, upright};
    use relcp::scene::WallMotion;

    #[test]
    fn free_ways_are_of_velocities_forces_and_walls() {
        let ball = moving(upright(sphere(0.5), [0.0; 3]), [3.0, 0.0, 4.0], [0.0, 2.0, 0.0]);
        let mut start = Start::inertial(0.1, vec![ball, upright(sphere(0.5), [3.0, 0.0, 0.0])]);
        let motion = Some(with!(angular_velocity: Some([0.0, 0.0, 1.0]), ..WallMotion::new([0.0, 2.0, 0.0])));
        start.scene.walls =
            vec![Wall::HalfSpace { normal: [1.0, 0.0, 0.0], offset: -1.0, motion, friction: None, load: None }];
        let (bodies, free) = (start.scene.build().unwrap(), Free::of(&start.scene));
        assert!((free.way(&bodies) - 0.5).abs() < 1e-12);
        assert!((free.turn(&bodies) - 0.1).abs() < 1e-12);
        assert!((free.walls_way(&bodies) - 0.6).abs() < 1e-12);
    }

    #[test]
    fn moves_are_told_by_id_whoever_left_and_was_born() {
        let balls: Vec<_> = (0..4).map(|i| upright(sphere(0.5), [f64::from(i), 0.0, 0.0])).collect();
        let before = Start::still(0.1, balls).scene.build().unwrap();
        let mut after = before.clone();
        after.position[2].y = 0.25;
        after.position[3].y = 7.0;
        after.lineage[3].id = 9;
        after.retain(&[false, true, true, true]);
        assert_eq!(farthest(&before, &after), (0.25, Some(2)));
        assert_eq!(born(&before, &after), 1);
        after.position[0].x = f64::NAN;
        assert!(farthest(&before, &after).0.is_nan());
    }
}
