//! The rules of walls, and that the bodies given one by one are inside of them.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::{Scene, Wall, WallMotion};
use super::forces::check_window;
use super::{number, numbers, positive};
use crate::digits::{exact, few, short};
use crate::separation::Placed;
use crate::walls::across;
use glam::DVec3;

/// Most walls of a scene: each body is held against every one in every trial.
const MAX_WALLS: usize = 1_000;

/// Least length of a normal or an axis; below it the direction is made of rounding.
const LEAST_DIRECTION: f64 = 1e-6;

impl Scene {
    pub(super) fn check_walls(&self, root: &Key) -> Result<(), SceneError> {
        let list = root.field("walls");
        if self.walls.len() > MAX_WALLS {
            let message = format!("{} walls; at most {MAX_WALLS}", self.walls.len());
            return Err(SceneError::new(FaultKind::TooLarge, list, message));
        }
        for (i, wall) in self.walls.iter().enumerate() {
            let key = list.index(i);
            let key = key.field(wall.name());
            check_wall(&key, wall)?;
            check_digits(&key, wall, self.contact.overlap_tolerance)?;
            if let Some(motion) = wall.motion() {
                self.check_motion(&key.field("motion"), wall, motion)?;
            }
            if let Some(load) = wall.load() {
                self.check_load(&key, wall, load)?;
            }
            if self.planar {
                check_upright(&key, wall, self.plane())?;
            }
        }
        if self.walls.is_empty() { Ok(()) } else { self.check_inside(&root.field("bodies")) }
    }

    /// A motion that stays in a planar scene's plane and keeps a periodic scene's wall along its periods, and that
    /// leads no farther than floats tell the overlap tolerance.
    fn check_motion(&self, key: &Key, wall: &Wall, motion: &WallMotion) -> Result<(), SceneError> {
        numbers(&key.field("velocity"), &motion.velocity)?;
        let turning = motion.angular_velocity.unwrap_or_default();
        numbers(&key.field("angular_velocity"), &turning)?;
        if let Some(window) = &motion.window {
            check_window(&key.field("window"), window)?;
        }
        let still = |name: &'static str, axis: usize, value: f64, why: &str| {
            let message = format!("must be 0 {why}, not {value}", value = exact(value));
            if value == 0.0 { Ok(()) } else { Err(SceneError::bad(key.field(name).index(axis), message)) }
        };
        if self.planar {
            let why = "in a planar scene, where walls move in the plane and turn about z";
            still("velocity", 2, motion.velocity[2], why)?;
            (0..2).try_for_each(|axis| still("angular_velocity", axis, turning[axis], why))?;
        }
        for along in (0..3).filter(|axis| self.periods().lengths()[*axis].is_some()) {
            let why = "in a periodic scene, where a wall turns about the one periodic axis alone";
            let others = (0..3).filter(|axis| *axis != along);
            others.into_iter().try_for_each(|axis| still("angular_velocity", axis, turning[axis], why))?;
        }
        let times = [self.time.start, self.time.end];
        let farthest = times.map(|time| wall.moved(time).map_or(0.0, |moved| moved.farthest()));
        if farthest[0].max(farthest[1]) * f64::EPSILON > self.contact.overlap_tolerance {
            let message = format!(
                "moves the wall so far by the run's end, {}, that 64-bit floats are coarser there than contact.overlap_tolerance; choose a smaller velocity, an earlier end or a window",
                short(farthest[0].max(farthest[1]))
            );
            return Err(SceneError::bad(key, message));
        }
        Ok(())
    }

    /// A body that a run wrote, which has a lineage, may reach past a wall as far as its method left it.
    fn check_inside(&self, key: &Key) -> Result<(), SceneError> {
        let walls = self.walls();
        for (i, body) in self.bodies.iter().enumerate().filter(|(_, body)| body.lineage.is_none()) {
            let placed =
                Placed { shape: body.shape, position: DVec3::from(body.position), orientation: body.rotation() };
            if let Some((depth, wall)) = walls.deepest(&placed).filter(|(d, _)| *d > self.contact.overlap_tolerance) {
                return Err(SceneError::bad(key.index(i).field("position"), self.outside(depth, wall)));
            }
        }
        Ok(())
    }

    /// What is wrong with a body that reaches past a wall.
    pub(crate) fn outside(&self, depth: f64, wall: usize) -> String {
        format!(
            "the body reaches {depth} past wall {wall} ({}); bodies must start inside all walls",
            self.walls[wall].name(),
            depth = few(depth)
        )
    }
}

pub(super) fn direction(key: &Key, vector: &[f64; 3]) -> Result<(), SceneError> {
    numbers(key, vector)?;
    let length = DVec3::from(*vector).length();
    if length < LEAST_DIRECTION {
        let message =
            format!("has the length {length}; a direction needs at least {LEAST_DIRECTION:e}", length = short(length));
        return Err(SceneError::bad(key, message));
    }
    Ok(())
}

pub(super) fn check_wall(key: &Key, wall: &Wall) -> Result<(), SceneError> {
    match wall {
        Wall::HalfSpace { normal, offset, .. } => {
            direction(&key.field("normal"), normal)?;
            number(&key.field("offset"), *offset)
        }
        Wall::Channel { normal, center, width, .. } => {
            direction(&key.field("normal"), normal)?;
            numbers(&key.field("center"), center)?;
            positive(&key.field("width"), *width)
        }
        Wall::Box { minimum, maximum, .. } => {
            numbers(&key.field("minimum"), minimum)?;
            numbers(&key.field("maximum"), maximum)?;
            for axis in 0..3 {
                if maximum[axis] <= minimum[axis] {
                    let message = format!("must be more than the minimum there, {}", exact(minimum[axis]));
                    return Err(SceneError::bad(key.field("maximum").index(axis), message));
                }
            }
            Ok(())
        }
        Wall::Sphere { center, radius, .. } => {
            numbers(&key.field("center"), center)?;
            positive(&key.field("radius"), *radius)
        }
        Wall::Cylinder { center, axis, radius, length, .. } => {
            numbers(&key.field("center"), center)?;
            direction(&key.field("axis"), axis)?;
            positive(&key.field("radius"), *radius)?;
            length.map_or(Ok(()), |length| positive(&key.field("length"), length))
        }
    }
}

/// A wall so far away or so large that 64-bit floats cannot tell the overlap tolerance there.
pub(super) fn check_digits(key: &Key, wall: &Wall, tolerance: f64) -> Result<(), SceneError> {
    let largest = |numbers: &[f64]| numbers.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let farthest = match wall {
        Wall::HalfSpace { offset, .. } => offset.abs(),
        Wall::Channel { center, width, .. } => largest(center).max(*width),
        Wall::Box { minimum, maximum, .. } => largest(minimum).max(largest(maximum)),
        Wall::Sphere { center, radius, .. } => largest(center).max(*radius),
        Wall::Cylinder { center, radius, length, .. } => largest(center).max(*radius).max(length.unwrap_or(0.0)),
    };
    if farthest * f64::EPSILON > tolerance {
        let message = format!(
            "is so large or far, {farthest}, that 64-bit floats are coarser there than contact.overlap_tolerance",
            farthest = short(farthest)
        );
        return Err(SceneError::bad(key, message));
    }
    Ok(())
}

/// Walls of a planar scene are mirrored by its plane.
pub(super) fn check_upright(key: &Key, wall: &Wall, plane: f64) -> Result<(), SceneError> {
    let in_plane = |name: &'static str, vector: &[f64; 3]| {
        if vector[2] == 0.0 {
            return Ok(());
        }
        let message = format!("must be 0 in a planar scene, where walls stand upright, not {}", exact(vector[2]));
        Err(SceneError::bad(key.field(name).index(2), message))
    };
    let on_plane = |center: &[f64; 3]| {
        if center[2] == plane {
            return Ok(());
        }
        let message =
            format!("must be on the scene's plane, z = {plane}, not {}", exact(center[2]), plane = exact(plane));
        Err(SceneError::bad(key.field("center").index(2), message))
    };
    match wall {
        Wall::HalfSpace { normal, .. } | Wall::Channel { normal, .. } => in_plane("normal", normal),
        Wall::Box { .. } => Ok(()),
        Wall::Sphere { center, .. } => on_plane(center),
        Wall::Cylinder { axis, .. } if across(DVec3::from(*axis)) => Ok(()),
        Wall::Cylinder { center, axis, .. } => in_plane("axis", axis).and_then(|()| on_plane(center)),
    }
}
