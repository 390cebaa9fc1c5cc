//! Thin discs: they fall on a floor and on each other, lie in cups, and are pressed between plates.

use super::super::place::{Manner, Placer};
use super::super::room::{self, Room};
use super::super::shapes::Mixture;
use super::super::{Drawn, drive};
use super::parts::{Closing, described, scene};
use super::rows::THIN;
use crate::hard::start::{Random, ellipsoid};
use glam::DVec3;
use relcp::scene::{Drag, Dynamics, Force, Scene, Wall};

/// Discs.
const COUNT: [f64; 2] = [1.0, 13.0];
/// Sizes of discs at most.
const MOST_SIZES: usize = 2;
/// Radii.
const RADIUS: [f64; 2] = [0.5, 1.0];
/// Half the space for a disc, in radii: a cube of this for each.
const SPACE: [f64; 2] = [0.6, 1.5];
/// What discs fall by in the whole run, in radii.
const FALL: [f64; 2] = [0.3, 10.0];
/// Steps of a fall.
const STEPS: [f64; 2] = [50.0, 400.0];

pub(super) fn draw(random: &mut Random, name: &str) -> Drawn {
    let planar = random.chance(0.25);
    let count = random.log_within(COUNT[0], COUNT[1]).floor();
    let mut shapes = Vec::new();
    for _ in 0..=random.below(MOST_SIZES) {
        let (radius, thin) = (random.within(RADIUS[0], RADIUS[1]), random.log_within(THIN[0], THIN[1]));
        shapes.push(ellipsoid([radius, radius, radius / thin]));
    }
    let thinnest = shapes.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min);
    let mixture = Mixture { shapes, what: format!("discs to 1:{:.0}", 2.0 * RADIUS[0] / thinnest) };
    let side = if planar { count.sqrt() } else { count.cbrt() };
    let half = (side * random.within(SPACE[0], SPACE[1]) * mixture.reach()).max(1.2 * mixture.reach());
    // Plates close until they nearly touch.
    let closing = Closing::draw(random, 1.9 * half, 0.2 * mixture.reach(), count as usize);
    let (mut scene, settings) = scene(random, name, planar, &closing, thinnest);
    let (walls, what) = walls(random, &closing, half, planar);
    let pressed = walls.iter().any(|wall| wall.motion().is_some());
    scene.walls = walls.clone();
    let room = Room { walls, periodic: None, half, what: what.into() };
    let manner = random.either(0.6, Manner::Clear, Manner::Touching);
    scene.bodies = Placer::new(&scene, &room).place(random, &mixture, count as usize, manner);
    if !pressed {
        fall(random, &mut scene, half);
    }
    let driven = random.chance(0.3).then(|| drive::drive(random, &mut scene, 0.5 * mixture.reach()));
    let what = format!("{} {} {} {what}", scene.bodies.len(), mixture.what, manner.name());
    Drawn { what: described(&scene, &what, driven.as_deref().unwrap_or(""), &settings), scene }
}

/// A pull against the first wall's normal that takes discs a way in the run, in most scenes with inertia.
fn fall(random: &mut Random, scene: &mut Scene, half: f64) {
    let steps = random.log_within(STEPS[0], STEPS[1]).floor();
    scene.time.end = steps * scene.time.dt;
    let way = random.log_within(FALL[0], FALL[1]).min(2.0 * half);
    let down = match scene.walls.first() {
        Some(Wall::HalfSpace { normal, .. }) => -DVec3::from(*normal),
        _ => DVec3::NEG_Y,
    };
    let time = scene.time.end;
    if random.chance(0.7) {
        scene.dynamics = Dynamics::Inertial { density: 1.0, drag: None };
    }
    scene.forces.push(match scene.dynamics {
        Dynamics::Overdamped { drag: Drag::Even(drag) } => {
            let force = 2.0 * drag * way / time * down;
            Force::Uniform { force: force.to_array(), group: None, window: None }
        }
        _ => {
            let acceleration = 2.0 * way / (time * time) * down;
            Force::Gravity { acceleration: acceleration.to_array(), group: None, window: None }
        }
    });
}

fn walls(random: &mut Random, closing: &Closing, half: f64, planar: bool) -> (Vec<Wall>, &'static str) {
    let up = room::direction(random, planar);
    let side = room::across(random, up, planar);
    match random.below(4) {
        0 => (vec![room::floor(up, half)], "fall on a floor"),
        1 => {
            let walls = vec![room::floor(up, half), room::channel(side, 2.0 * half)];
            (walls, "fall into a gap")
        }
        2 => (vec![closing.wall(up, half), room::floor(-up, half)], "under a plate that closes"),
        _ => ([up, -up].map(|normal| closing.wall(normal, half)).to_vec(), "between plates that close"),
    }
}
