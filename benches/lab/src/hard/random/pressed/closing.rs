//! Pistons, plates and boxes that close on bodies of every kind.

use super::super::place::{Manner, Placer};
use super::super::room::{self, Room};
use super::super::shapes::Mixture;
use super::super::{Drawn, drive};
use super::parts::{Closing, described, scene};
use crate::hard::start::Random;
use glam::{DQuat, DVec3};
use relcp::scene::Wall;
use std::f64::consts::TAU;

/// Bodies.
const COUNT: [f64; 2] = [2.0, 41.0];
/// What they are of the space at the start.
const FRACTION: [f64; 2] = [0.05, 0.3];
/// What a space closes by, of its width.
const SHORTER: [f64; 2] = [0.1, 0.7];
/// Half a space at least, in longest extents.
const LEAST_HALF: f64 = 1.2;

pub(super) fn draw(random: &mut Random, name: &str) -> Drawn {
    let planar = random.chance(0.5);
    let mixture = Mixture::draw(random);
    let count = random.log_within(COUNT[0], COUNT[1]).floor();
    let half = half(random, &mixture, count, planar);
    let shorter = random.within(SHORTER[0], SHORTER[1]) * 2.0 * half;
    let closing = Closing::draw(random, shorter, mixture.thinnest(), count as usize);
    let (mut scene, settings) = scene(random, name, planar, &closing, mixture.thinnest());
    let (walls, what) = walls(random, &closing, half, planar);
    scene.walls = walls.clone();
    let room = Room { walls, periodic: None, half, what: what.into() };
    let manner = random.either(0.7, Manner::Clear, Manner::Touching);
    scene.bodies = Placer::new(&scene, &room).place(random, &mixture, count as usize, manner);
    let driven = random.chance(0.3).then(|| drive::drive(random, &mut scene, mixture.thinnest()));
    let what = format!("{} {} {} {what}", scene.bodies.len(), mixture.what, manner.name());
    Drawn { what: described(&scene, &what, driven.as_deref().unwrap_or(""), &settings), scene }
}

/// Returns half the width of a space for a number of bodies.
fn half(random: &mut Random, mixture: &Mixture, count: f64, planar: bool) -> f64 {
    let fraction = random.log_within(FRACTION[0], FRACTION[1]);
    let sizes = mixture.shapes.iter().map(|shape| match planar {
        true => shape.thickness() * shape.major_axis(),
        false => shape.volume(),
    });
    let size = count * sizes.sum::<f64>() / (mixture.shapes.len() as f64 * fraction);
    (0.5 * if planar { size.sqrt() } else { size.cbrt() }).max(LEAST_HALF * mixture.reach())
}

/// Draws walls around the origin in a random orientation. Some or all of them close.
fn walls(random: &mut Random, closing: &Closing, half: f64, planar: bool) -> (Vec<Wall>, &'static str) {
    let turned = random.within(0.0, TAU);
    let turn = match (random.chance(0.5), planar) {
        (true, _) => DQuat::IDENTITY,
        (false, true) => DQuat::from_rotation_z(turned),
        (false, false) => random.orientation(),
    };
    let axes = if planar { 2 } else { 3 };
    let way = |axis: usize| {
        let way = turn * DVec3::AXES[axis];
        // Exactly in the plane, which a turn about z keeps only up to rounding.
        if planar { way.with_z(0.0).normalize() } else { way.normalize() }
    };
    let moving = |axis: usize| [way(axis), -way(axis)].map(|normal| closing.wall(normal, half));
    let still = |axis: usize| [way(axis), -way(axis)].map(|normal| room::floor(normal, half));
    match random.below(4) {
        0 => {
            let piston = [closing.wall(way(0), half), room::floor(-way(0), half)];
            (piston.into_iter().chain((1..axes).flat_map(still)).collect(), "under a piston")
        }
        1 => (moving(0).to_vec(), "between plates that close"),
        2 => (moving(0).into_iter().chain((1..axes).flat_map(still)).collect(), "between two pistons"),
        _ => ((0..axes).flat_map(moving).collect(), "in a box that closes"),
    }
}
