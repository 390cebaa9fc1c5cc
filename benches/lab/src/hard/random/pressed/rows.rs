//! Rows and stacks in line between walls that close: balls, rods end to end, ellipsoids tip to tip, thin discs face to
//! face.

use super::super::{Drawn, drive, room};
use super::parts::{Closing, along, described, misalignment, out_of_line, scene, turn};
use crate::hard::start::{Random, body, ellipsoid, rod, sphere};
use glam::{DQuat, DVec3};
use relcp::scene::{Body, Wall};
use relcp::shape::Shape;

/// Bodies of a row.
const COUNT: [f64; 2] = [2.0, 13.0];
/// Discs of a stack at most: twelve of them take minutes for twenty steps.
const MOST_DISCS: f64 = 6.0;
/// What a row is shortened by, of its length.
const SHORTER: [f64; 2] = [0.05, 0.5];
/// Lengths of rods and ellipsoids over their widths.
const LONG: [f64; 2] = [1.05, 8.0];
/// Widths of discs over their thicknesses.
pub(super) const THIN: [f64; 2] = [10.0, 1000.0];
/// Half the largest extent.
const REACH: [f64; 2] = [0.25, 1.0];
/// Gaps between the bodies of a row, in their extents along it.
const MOST_GAP: f64 = 0.05;
/// Room of a row that has sides, beside its width, as a part of it.
const SLACK: [f64; 2] = [1e-6, 1.0];

/// One body of a row: its extent along the row and across.
struct Member {
    shape: Shape,
    along: f64,
    across: f64,
    what: &'static str,
}

impl Member {
    fn draw(random: &mut Random) -> Member {
        let reach = random.log_within(REACH[0], REACH[1]);
        let (long, thin) = (random.log_within(LONG[0], LONG[1]), random.log_within(THIN[0], THIN[1]));
        let (width, second) = (2.0 * reach / long, random.within(0.5, 1.0));
        let of = |shape: Shape, along: f64, across: f64, what: &'static str| Member { shape, along, across, what };
        match random.below(5) {
            0 => of(sphere(reach), 2.0 * reach, 2.0 * reach, "balls"),
            1 => of(rod(width, 2.0 * reach), 2.0 * reach, width, "rods end to end"),
            2 => of(ellipsoid([0.5 * width, 0.5 * width, reach]), 2.0 * reach, width, "ellipsoids tip to tip"),
            3 => {
                let radii = [0.5 * width, 0.5 * width * second, reach];
                of(ellipsoid(radii), 2.0 * reach, width, "ellipsoids of three axes tip to tip")
            }
            _ => of(ellipsoid([reach, reach, reach / thin]), 2.0 * reach / thin, 2.0 * reach, "discs face to face"),
        }
    }

    fn thickness(&self) -> f64 {
        self.along.min(self.across)
    }
}

pub(super) fn draw(random: &mut Random, name: &str) -> Drawn {
    let planar = random.chance(0.5);
    let member = Member::draw(random);
    let count = random.log_within(COUNT[0], COUNT[1]).floor();
    let count = if member.along < member.across { count.min(MOST_DISCS) } else { count };
    let gap = random.within(0.0, MOST_GAP) * member.along;
    let gap = random.either(0.5, 0.0, gap);
    let snug = random.chance(0.1);
    // Between sides as wide as they are, bodies are in line.
    let out = if snug { 0.0 } else { misalignment(random) };
    let way = room::direction(random, planar);
    // A body that is turned is longer along the row.
    let pitch = member.along + out * member.across + gap;
    let shorter = random.within(SHORTER[0], SHORTER[1]) * count * pitch;
    let closing = Closing::draw(random, shorter, member.thickness(), count as usize);
    let (mut scene, settings) = scene(random, name, planar, &closing, member.shape.thickness());
    let half = 0.5 * count * pitch;
    scene.walls = vec![closing.wall(way, half)];
    let both = random.chance(0.3);
    scene.walls.push(if both { closing.wall(-way, half) } else { room::floor(-way, half) });
    let sides = sides(random, &member, (way, planar), snug, out);
    scene.walls.extend(sides);
    scene.bodies = row(random, &member, count as usize, [pitch, out], (way, planar));
    let driven = random.chance(0.3).then(|| drive::drive(random, &mut scene, 0.5 * member.across));
    let sided = if sides.is_some() { ", between sides" } else { "" };
    let what = format!("a row of {count} {}, {}{sided}", member.what, out_of_line(out));
    Drawn { what: described(&scene, &what, driven.as_deref().unwrap_or(""), &settings), scene }
}

/// The bodies, about the origin, each out of line and turned by up to `out` of its width.
fn row(
    random: &mut Random,
    member: &Member,
    count: usize,
    [pitch, out]: [f64; 2],
    (way, planar): (DVec3, bool),
) -> Vec<Body> {
    let straight = along(way, planar);
    let middle = 0.5 * (count as f64 - 1.0);
    let one = |i: usize| {
        let aside = out * random.within(-0.5, 0.5) * member.across * room::across(random, way, planar);
        // In line a body's own axis is the row's to the last bit.
        let turned = if out > 0.0 { turn(random, 0.5 * out, planar) } else { DQuat::IDENTITY };
        body(member.shape, ((i as f64 - middle) * pitch * way + aside).to_array(), (turned * straight).normalize())
    };
    (0..count).map(one).collect()
}

/// Walls along the row, as far apart as its bodies need and some slack; none in most scenes.
fn sides(random: &mut Random, member: &Member, (way, planar): (DVec3, bool), snug: bool, out: f64) -> Option<Wall> {
    let drawn = random.log_within(SLACK[0], SLACK[1]);
    let (sided, round) = (random.chance(0.3), random.chance(0.5));
    let slack = if snug { 0.0 } else { sided.then_some(drawn + 2.0 * out)? };
    let width = member.across * (1.0 + slack) + out * member.along;
    match planar || !round {
        true => Some(room::channel(room::across(random, way, planar), width)),
        false => Some(Wall::Cylinder {
            center: [0.0; 3],
            axis: way.to_array(),
            radius: 0.5 * width,
            length: None,
            motion: None,
            friction: None,
        }),
    }
}
