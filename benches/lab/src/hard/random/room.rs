//! The space of a drawn scene: open, within walls of every kind, or periodic.

use crate::hard::start::Random;
use glam::{DQuat, DVec3};
use relcp::scene::{Periodic, Wall};
use std::f64::consts::TAU;

/// The space of the bodies.
pub(super) struct Room {
    pub(super) walls: Vec<Wall>,
    pub(super) periodic: Option<Periodic>,
    /// Half the cube in which centres are drawn.
    pub(super) half: f64,
    pub(super) what: String,
}

/// The requirements of a room.
#[derive(Clone, Copy, Debug)]
pub(super) struct Needs {
    pub(super) planar: bool,
    /// Half the room's size, a length.
    pub(super) half: f64,
    /// The least period that validation accepts.
    pub(super) least_period: f64,
}

/// The smallest ratio of a period to the least valid period.
const PERIOD_SLACK: f64 = 1.001;

impl Room {
    pub(super) fn draw(random: &mut Random, needs: Needs) -> Room {
        let half = needs.half;
        let open = |walls: Vec<Wall>, what: &str| Room { walls, periodic: None, half, what: what.to_owned() };
        match random.below(14) {
            0 | 1 => open(Vec::new(), "open space"),
            2 | 3 => periodic(random, needs),
            4 => open(vec![floor(direction(random, needs.planar), half)], "over a floor"),
            5 => corner(random, needs),
            6 => open(vec![channel(direction(random, needs.planar), 2.0 * half)], "in a channel"),
            7 => open(vec![cube(half)], "in a box"),
            8 => open(vec![ball(1.3 * half)], "in a sphere"),
            9 => tube(random, needs),
            10 | 11 => cup(random, needs),
            12 => {
                let normal = direction(random, needs.planar);
                let walls = vec![channel(normal, 2.0 * half), floor(across(random, normal, needs.planar), half)];
                open(walls, "in a closed channel")
            }
            _ => {
                let normal = direction(random, needs.planar);
                open(vec![channel(normal, 1.6 * half), ball(1.3 * half)], "in a sphere and a channel")
            }
        }
    }
}

/// A unit vector, in the plane where the scene is planar; one in four along an axis.
pub(super) fn direction(random: &mut Random, planar: bool) -> DVec3 {
    let (sin, cos) = (TAU * random.within(0.0, 1.0)).sin_cos();
    match (random.chance(0.25), planar) {
        (true, true) => [DVec3::X, DVec3::Y][random.below(2)],
        (true, false) => DVec3::AXES[random.below(3)],
        (false, true) => DVec3::new(cos, sin, 0.0),
        (false, false) => random.direction(),
    }
}

/// A unit vector at right angles to another.
pub(super) fn across(random: &mut Random, normal: DVec3, planar: bool) -> DVec3 {
    if planar {
        return DVec3::new(-normal.y, normal.x, 0.0);
    }
    let (u, v) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * random.within(0.0, 1.0)).sin_cos();
    cos * u + sin * v
}

pub(super) fn floor(normal: DVec3, below: f64) -> Wall {
    Wall::HalfSpace { normal: normal.to_array(), offset: -below, motion: None, friction: None, load: None }
}

pub(super) fn channel(normal: DVec3, width: f64) -> Wall {
    Wall::Channel { normal: normal.to_array(), center: [0.0; 3], width, motion: None, friction: None }
}

fn ball(radius: f64) -> Wall {
    Wall::Sphere { center: [0.0; 3], radius, motion: None, friction: None }
}

fn cube(half: f64) -> Wall {
    Wall::Box { minimum: [-half; 3], maximum: [half; 3], motion: None, friction: None }
}

/// Two or three floors that meet at any angle, sharp ones too.
fn corner(random: &mut Random, needs: Needs) -> Room {
    let Needs { planar, half, .. } = needs;
    let mut walls = vec![floor(direction(random, planar), half)];
    for _ in 0..=random.below(2) {
        walls.push(floor(direction(random, planar), half));
    }
    Room { periodic: None, half, what: format!("in a corner of {} floors", walls.len()), walls }
}

/// A cylinder with or without ends.
fn tube(random: &mut Random, needs: Needs) -> Room {
    let axis = if needs.planar && random.chance(0.5) { DVec3::Z } else { direction(random, needs.planar) };
    let length = random.either(0.5, Some(2.0 * needs.half), None);
    let wall = Wall::Cylinder {
        center: [0.0; 3],
        axis: axis.to_array(),
        radius: 1.2 * needs.half,
        length,
        motion: None,
        friction: None,
    };
    let what = if length.is_some() { "in a can" } else { "in a tube" };
    Room { walls: vec![wall], periodic: None, half: needs.half, what: what.into() }
}

/// Draws a box that is open at one side, in a random orientation.
fn cup(random: &mut Random, needs: Needs) -> Room {
    let Needs { planar, half, .. } = needs;
    let turn = match (random.chance(0.5), planar) {
        (true, _) => DQuat::IDENTITY,
        (false, true) => DQuat::from_rotation_z(TAU * random.within(0.0, 1.0)),
        (false, false) => random.orientation(),
    };
    let sides: &[DVec3] = match planar {
        true => &[DVec3::X, DVec3::NEG_X, DVec3::Y],
        false => &[DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z],
    };
    let turned = |side: &DVec3| if turn == DQuat::IDENTITY { *side } else { (turn * *side).normalize() };
    // Exactly in the plane, which a turn about z keeps only up to rounding.
    let flat = |side: DVec3| if planar { side.with_z(0.0) } else { side };
    let walls = sides.iter().map(|side| floor(flat(turned(side)), half)).collect();
    Room { walls, periodic: None, half, what: "in a cup".into() }
}

/// A cell that is periodic along some axes, with a channel or a tube along them where there is another axis.
fn periodic(random: &mut Random, needs: Needs) -> Room {
    let axes = if needs.planar { 2 } else { 3 };
    let period = (2.0 * needs.half).max(PERIOD_SLACK * needs.least_period);
    let count = 1 + random.below(axes);
    let first = random.below(axes);
    let mut lengths = [None; 3];
    for i in 0..count {
        let longer = random.within(1.0, 1.5);
        lengths[(first + i) % axes] = Some(period * random.either(0.5, 1.0, longer));
    }
    let open: Vec<usize> = (0..axes).filter(|axis| lengths[*axis].is_none()).collect();
    let mut walls = Vec::new();
    if let ([axis, ..], true) = (&open[..], random.chance(0.5)) {
        walls.push(match (needs.planar, open.len()) {
            (false, 2) if random.chance(0.5) => {
                let along = DVec3::AXES[first].to_array();
                Wall::Cylinder {
                    center: [0.0; 3],
                    axis: along,
                    radius: 1.2 * needs.half,
                    length: None,
                    motion: None,
                    friction: None,
                }
            }
            _ => channel(DVec3::AXES[*axis], 2.0 * needs.half),
        });
    }
    let walled = if walls.is_empty() { "" } else { ", within a wall" };
    Room {
        walls,
        periodic: Some(Periodic::new(lengths)),
        half: 0.5 * period,
        what: format!("periodic along {count} of {axes} axes{walled}"),
    }
}
