//! The initial poses of the bodies of a drawn scene: apart, touching, or with slight or large overlaps, always inside
//! the walls.

use super::room::Room;
use super::shapes::{Mixture, turned};
use crate::hard::start::{Random, body};
use glam::DVec3;
use relcp::periodic::Periods;
use relcp::scene::{Body, Scene};
use relcp::separation::{Placed, separation};
use relcp::walls::Walls;

/// How bodies start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Manner {
    Clear,
    Touching,
    Slight,
    Gross,
}

impl Manner {
    pub(super) fn draw(random: &mut Random) -> Manner {
        match random.below(10) {
            0..=3 => Manner::Clear,
            4..=5 => Manner::Touching,
            6..=7 => Manner::Slight,
            _ => Manner::Gross,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Manner::Clear => "apart",
            Manner::Touching => "touching",
            Manner::Slight => "slightly overlapping",
            Manner::Gross => "grossly overlapping",
        }
    }
}

/// Places that are tried for a body before it is left out.
const TRIES: usize = 40;
/// Looks at the gap on the way of a body until it touches: each leaves a part of it, which oblique contacts make large.
const LOOKS: usize = 80;
/// A gap below this part of a length counts as none: some tens of roundings.
const TOUCHES: f64 = 1e-14;
/// Slight overlaps, as parts of the thinnest body's thickness.
const SLIGHT: [f64; 2] = [1e-8, 0.3];
/// The probability that a largely overlapping body is exactly at the position of another one.
const SAME_PLACE: f64 = 0.1;

/// Places bodies in a scene whose walls and periods are settled.
pub(super) struct Placer<'a> {
    scene: &'a Scene,
    walls: Walls,
    periods: Periods,
    half: f64,
    placed: Vec<Placed>,
}

impl<'a> Placer<'a> {
    pub(super) fn new(scene: &'a Scene, room: &Room) -> Self {
        Placer { scene, walls: scene.walls(), periods: scene.periods(), half: room.half, placed: Vec::new() }
    }

    /// `count` bodies, or as many as find a place.
    pub(super) fn place(mut self, random: &mut Random, mixture: &Mixture, count: usize, manner: Manner) -> Vec<Body> {
        for _ in 0..count {
            let shape = mixture.shapes[random.below(mixture.shapes.len())];
            let turn = |random: &mut Random| turned(random, &shape, self.scene.planar, !self.scene.growth.is_empty());
            let orientation = turn(random);
            let at = |position: DVec3| Placed { shape, position, orientation };
            let found = (0..TRIES).map(|_| at(self.anywhere(random))).find(|body| self.fits(body, manner));
            let same = manner == Manner::Gross && random.chance(SAME_PLACE);
            let found = if same { self.placed.last().copied().or(found) } else { found };
            self.placed.extend(found);
        }
        if matches!(manner, Manner::Touching | Manner::Slight) {
            self.gather(random, manner, mixture.thinnest());
        }
        self.placed.iter().map(|placed| body(placed.shape, placed.position.to_array(), placed.orientation)).collect()
    }

    fn anywhere(&self, random: &mut Random) -> DVec3 {
        let position = self.half * random.vector();
        if self.scene.planar { position.with_z(0.0) } else { position }
    }

    fn fits(&self, body: &Placed, manner: Manner) -> bool {
        let inside = self.to_walls(body) >= 0.0;
        inside && (manner == Manner::Gross || self.to_bodies(body, None) >= 0.0)
    }

    /// Moves body after body, all the same way or all to the middle, until it touches.
    fn gather(&mut self, random: &mut Random, manner: Manner, thickness: f64) {
        let down = random.chance(0.5).then(|| self.way(random));
        let mut order: Vec<usize> = (0..self.placed.len()).collect();
        let height =
            |i: usize| down.map_or(self.placed[i].position.length(), |down| -down.dot(self.placed[i].position));
        order.sort_by(|a, b| height(*a).total_cmp(&height(*b)));
        for i in order {
            let way = down.unwrap_or(-self.placed[i].position.normalize_or_zero());
            self.move_until_it_touches(i, way);
            let deeper = random.log_within(SLIGHT[0], SLIGHT[1]) * thickness;
            if manner == Manner::Slight {
                let mut pushed = self.placed[i];
                pushed.position += deeper * way;
                if self.to_walls(&pushed) >= 0.0 {
                    self.placed[i] = pushed;
                }
            }
        }
    }

    fn way(&self, random: &mut Random) -> DVec3 {
        let way = random.direction();
        if self.scene.planar { way.with_z(0.0).normalize_or(DVec3::X) } else { way }
    }

    /// Goes as far as the least gap each time, which no body can be passed in; stays where it meets nothing.
    fn move_until_it_touches(&mut self, i: usize, way: DVec3) {
        let mut body = self.placed[i];
        for _ in 0..LOOKS {
            let gap = self.to_walls(&body).min(self.to_bodies(&body, Some(i)));
            if gap <= TOUCHES {
                self.placed[i] = body;
                return;
            }
            body.position += gap.min(self.half) * way;
            // In the middle, or outside of all.
            let gone = body.position.length() > 4.0 * self.half;
            if gone {
                return;
            }
        }
        if self.to_walls(&body) >= 0.0 {
            self.placed[i] = body;
        }
    }

    fn to_walls(&self, body: &Placed) -> f64 {
        let gaps = self.walls.surfaces().iter().map(|surface| surface.separation(body).separation);
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// The least gap to other bodies.
    fn to_bodies(&self, body: &Placed, without: Option<usize>) -> f64 {
        let others = self.placed.iter().enumerate().filter(|(i, _)| Some(*i) != without);
        others.fold(f64::INFINITY, |least, (_, other)| {
            let [a, b] = self.periods.pair(*other, *body);
            let apart = (b.position - a.position).length();
            let bound = apart - a.shape.bounding_radius() - b.shape.bounding_radius();
            if bound >= least {
                return least;
            }
            separation(&a, &b, None).map_or(least, |found| least.min(found.separation))
        })
    }
}
