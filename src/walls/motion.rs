//! How walls move: with a velocity, and turning about their own reference point, which goes with it, while a window of
//! time is on. A wall stands as the scene gives it at time 0; where it is at another time is the exact integral of its
//! motion until then, and so depends on that time alone.

use crate::separation::Surface;
use crate::window::Window;
use glam::{DQuat, DVec3};

/// The motion of a wall. At time 0 it is where the scene places it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct WallMotion {
    /// Its velocity.
    pub velocity: [f64; 3],
    /// Its angular velocity about its reference point, which moves with it: the point of a half space's plane that is
    /// nearest to the origin, the `center` of a channel, sphere or cylinder, the middle of a box. Without it: none.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub angular_velocity: Option<[f64; 3]>,
    /// When it moves. Without it: always.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub window: Option<Window>,
}

impl WallMotion {
    /// A motion without turn.
    pub const fn new(velocity: [f64; 3]) -> WallMotion {
        WallMotion { velocity, angular_velocity: None, window: None }
    }

    /// How long it moves from time 0 until `time`, negative before 0.
    fn moving_until(&self, time: f64) -> f64 {
        let span = if time >= 0.0 { [0.0, time] } else { [time, 0.0] };
        if time == 0.0 { 0.0 } else { time * self.window.map_or(1.0, |window| window.share(span)) }
    }

    /// Where a wall with this reference point is at `time`.
    pub(crate) fn at(&self, reference: DVec3, time: f64) -> Moved {
        let moving = self.moving_until(time);
        let shift = moving * DVec3::from(self.velocity);
        let turn = self.angular_velocity.map(|turning| DQuat::from_scaled_axis(moving * DVec3::from(turning)));
        Moved { reference, shift, turn }
    }
}

/// Where a wall is that has moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moved {
    /// Its reference point as the scene gives it.
    pub reference: DVec3,
    /// How far it has gone.
    pub shift: DVec3,
    /// How it has turned about its reference point.
    pub turn: Option<DQuat>,
}

impl Moved {
    /// Where a point of the wall is.
    pub fn point(&self, point: DVec3) -> DVec3 {
        match self.turn {
            Some(turn) => self.reference + self.shift + turn * (point - self.reference),
            None => point + self.shift,
        }
    }

    /// Which point of the wall is at a place: the inverse of [`Moved::point`].
    pub fn back(&self, place: DVec3) -> DVec3 {
        match self.turn {
            Some(turn) => self.reference + turn.conjugate() * (place - self.reference - self.shift),
            None => place - self.shift,
        }
    }

    /// The largest coordinate of its reference point.
    pub fn farthest(&self) -> f64 {
        (self.reference + self.shift).abs().max_element()
    }

    fn direction(&self, direction: DVec3) -> DVec3 {
        self.turn.map_or(direction, |turn| (turn * direction).normalize())
    }

    /// Where a surface of the wall is.
    pub fn surface(&self, surface: &Surface) -> Surface {
        match *surface {
            Surface::Plane { point, normal } => {
                Surface::Plane { point: self.point(point), normal: self.direction(normal) }
            }
            Surface::Sphere { centre, radius } => Surface::Sphere { centre: self.point(centre), radius },
            Surface::Cylinder { centre, axis, radius } => {
                Surface::Cylinder { centre: self.point(centre), axis: self.direction(axis), radius }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_wall_is_where_its_motion_has_led_by_then() {
        let plane = Surface::Plane { point: DVec3::new(0.0, -2.0, 1.0), normal: DVec3::Y };
        let reference = DVec3::new(0.0, -2.0, 0.0);
        let going = WallMotion::new([0.5, 1.0, 0.0]);
        let Surface::Plane { point, normal } = going.at(reference, 4.0).surface(&plane) else { panic!("a plane") };
        assert_eq!((point, normal), (DVec3::new(2.0, 2.0, 1.0), DVec3::Y));
        assert_eq!(going.at(reference, 0.0).surface(&plane), plane);
        // For half of the time a quarter of a turn a unit of time.
        let turning = WallMotion {
            angular_velocity: Some([0.0, 0.0, FRAC_PI_2]),
            window: Some(Window::every(2.0, 0.5)),
            ..going
        };
        let moved = turning.at(reference, 1.75);
        let Surface::Plane { point, normal } = moved.surface(&plane) else { panic!("a plane") };
        assert!(normal.abs_diff_eq(DVec3::NEG_X, 1e-15), "{normal}");
        assert!(point.abs_diff_eq(DVec3::new(0.5, -1.0, 1.0), 1e-15), "{point}");
        assert_eq!(turning.at(reference, 1.0), turning.at(reference, 2.0));
        assert_eq!(turning.at(reference, -1.0).shift, DVec3::ZERO, "off before 0");
        let place = DVec3::new(3.0, 1.0, -2.0);
        assert!(moved.point(moved.back(place)).abs_diff_eq(place, 1e-14));
    }
}
