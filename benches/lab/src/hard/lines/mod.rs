//! Bodies in line between closing walls: their expected and computed final positions.
//!
//! The length of each body along the row is 2, and one wall closes with speed 1. Two pressed balls keep their distance,
//! so the positions of the walls determine their offset from each other. For other rows, a run with a small step
//! determines it, unless they are exactly in line; then the direction in which they buckle is random.

mod page;
mod run;

pub use page::{csv, page};
pub use run::{Row, run, run_all};

use super::Size;
use super::start::{Random, Start, body, ellipsoid, rod, sphere};
use glam::{DQuat, DVec3};
use relcp::scene::{Body, Dynamics, Wall, WallMotion};
use relcp::shape::Shape;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// How far bodies are out of line: none, the least that a step notices, as a person places them, and clearly.
const MISALIGNMENTS: [f64; 4] = [0.0, 1e-6, 5e-4, 1e-2];
/// What the misalignments of a row are drawn from.
const SEED: u64 = 3;
/// When a run ends: the walls have closed by half of a body's length.
const END: f64 = 1.0;
/// The same in a sphere, where the pair turns: by then by 60 degrees.
const END_IN_SPHERE: f64 = 0.5;

/// The bodies in line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Balls of radius 1.
    Balls,
    /// Rods of diameter 1, end to end.
    Rods,
    /// Ellipsoids of radii 0.3, 0.3, 1, tip to tip.
    Ellipsoids,
    /// Balls of radius 1 in a sphere of radius 2, which both touch.
    InSphere,
}

impl Kind {
    fn shape(self) -> Shape {
        match self {
            Kind::Balls | Kind::InSphere => sphere(1.0),
            Kind::Rods => rod(1.0, 2.0),
            Kind::Ellipsoids => ellipsoid([0.3, 0.3, 1.0]),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Kind::Balls => "balls",
            Kind::Rods => "rods end to end",
            Kind::Ellipsoids => "ellipsoids tip to tip",
            Kind::InSphere => "balls in a sphere",
        }
    }
}

/// The rows that are pressed: what and how many.
const ROWS: [(Kind, usize); 10] = [
    (Kind::Balls, 2),
    (Kind::Balls, 3),
    (Kind::Balls, 8),
    (Kind::Balls, 20),
    (Kind::InSphere, 2),
    (Kind::Rods, 2),
    (Kind::Rods, 3),
    (Kind::Rods, 8),
    (Kind::Ellipsoids, 2),
    (Kind::Ellipsoids, 3),
];

/// A row of bodies that is pressed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Line {
    /// What.
    pub kind: Kind,
    /// Their number.
    pub count: usize,
    /// Whether in the plane.
    pub planar: bool,
    /// Whether with inertia.
    pub inertial: bool,
    /// How far out of line, a length and an angle.
    pub misalignment: f64,
}

/// All of them; of a quick study those of two bodies.
pub fn all(size: Size) -> Vec<Line> {
    let mut lines = Vec::new();
    let most = if size == Size::QUICK { 2 } else { usize::MAX };
    for (kind, count) in ROWS.into_iter().filter(|(_, count)| *count <= most) {
        for (planar, inertial) in [(true, false), (false, false), (true, true), (false, true)] {
            lines.extend(MISALIGNMENTS.map(|misalignment| Line { kind, count, planar, inertial, misalignment }));
        }
    }
    lines
}

impl Line {
    /// In words.
    pub fn what(&self) -> String {
        format!("{} {}", self.count, self.kind.name())
    }

    /// The run with steps of `dt`.
    pub fn start(&self, dt: f64) -> Start {
        let mut start = Start::still(dt, self.bodies());
        let scene = &mut start.scene;
        scene.planar = self.planar;
        scene.time.end = if self.kind == Kind::InSphere { END_IN_SPHERE } else { END };
        if self.inertial {
            scene.dynamics = Dynamics::Inertial { density: 1.0, drag: None };
        }
        let half = self.count as f64;
        let closes = Some(WallMotion::new([-1.0, 0.0, 0.0]));
        let other = match self.kind {
            Kind::InSphere => Wall::Sphere { center: [0.0; 3], radius: 2.0, motion: None, friction: None },
            _ => Wall::HalfSpace { normal: [1.0, 0.0, 0.0], offset: -half, motion: None, friction: None, load: None },
        };
        scene.walls = vec![
            other,
            Wall::HalfSpace { normal: [-1.0, 0.0, 0.0], offset: -half, motion: closes, friction: None, load: None },
        ];
        start
    }

    /// How far two balls are aside of each other at the end, where they follow the walls.
    pub fn right_offset(&self) -> Option<f64> {
        let follows = !self.inertial && self.count == 2;
        match self.kind {
            // Two in touch, 2 apart, of which the walls leave 1 along the row.
            Kind::Balls if follows => Some(3.0_f64.sqrt()),
            // Both ends of a diameter of 2, the one at the wall at half a radius.
            Kind::InSphere if follows => Some(3.0_f64.sqrt()),
            _ => None,
        }
    }

    fn bodies(&self) -> Vec<Body> {
        let out = self.misalignment;
        if self.kind == Kind::InSphere {
            let (sin, cos) = out.asin().sin_cos();
            return [-1.0, 1.0].map(|side| body(sphere(1.0), [side * cos, side * sin, 0.0], DQuat::IDENTITY)).into();
        }
        let mut random = Random::new(SEED);
        let middle = 0.5 * (self.count as f64 - 1.0);
        let along = DQuat::from_rotation_y(FRAC_PI_2);
        let one = |i: usize| {
            let (aside, turn) = (random.vector(), random.vector());
            let x = 2.0 * (i as f64 - middle);
            let aside = match (self.count, self.planar) {
                (2, _) => x.signum() * DVec3::Y,
                (_, true) => DVec3::new(0.0, aside.y, 0.0),
                (_, false) => DVec3::new(0.0, aside.y, aside.z),
            };
            let turn = if self.planar { DVec3::Z * turn.z } else { turn };
            let turned = match self.kind {
                Kind::Rods | Kind::Ellipsoids => DQuat::from_scaled_axis(out * turn) * along,
                _ => DQuat::IDENTITY,
            };
            body(self.kind.shape(), (x * DVec3::X + out * aside).to_array(), turned.normalize())
        };
        (0..self.count).map(one).collect()
    }
}

#[cfg(test)]
mod tests;
