//! The walls of a scene: surfaces that bodies stay inside of, without unknowns. They stand still, have a motion of
//! their own, or are moved by a load.
//!
//! Each surface of a wall (a box has six) is to a body like another body that nothing can push: it has a number in the
//! place of a body's, so that pairs, rows and what a step remembers are the same for both, and in an LCP its block of
//! `J` is zero.

mod area;
mod enclosure;
#[cfg(feature = "files")]
mod lines;
mod load;
mod motion;
mod number;
#[cfg(feature = "files")]
mod push;
mod space;
mod wall;

#[cfg(feature = "files")]
pub(crate) use lines::{Line, edges};
pub use load::WallLoad;
pub(crate) use load::left;
#[cfg(feature = "files")]
pub(crate) use load::standing;
#[cfg(feature = "files")]
pub(crate) use motion::Moved;
pub use motion::WallMotion;
#[cfg(feature = "gpu")]
pub(crate) use number::AtSurface;
pub(crate) use number::{in_rows, of_rows};
pub use number::{number_of, surface_of};
#[cfg(feature = "files")]
pub(crate) use push::WallPush;
pub use wall::Wall;
pub(crate) use wall::across;

pub use crate::bodies::WallState;

use crate::bodies::Bodies;
use crate::periodic::Periods;
use crate::separation::{Placed, Separation, Surface};
use glam::DVec3;
use load::Loaded;
use rayon::prelude::*;

/// A loop over fewer bodies than this runs on one thread; a body's gap to a surface takes some 20 ns.
const LEAST_BODIES_A_TASK: usize = 512;

/// A body near a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WallContact {
    /// The body's row.
    pub body: usize,
    /// The wall's place in the scene's list.
    pub wall: usize,
    /// The body's signed distance from one of the wall's surfaces, a length; negative where it reaches past it.
    pub separation: f64,
    /// Unit normal towards the wall.
    pub normal: DVec3,
    /// From the body's centre to the contact point on its surface.
    pub lever: DVec3,
    /// The surface, by its place among those of all walls, in order.
    pub surface: usize,
}

impl WallContact {
    pub(crate) fn new(body: usize, [wall, surface]: [usize; 2], found: Separation) -> WallContact {
        let Separation { separation, normal, lever_a: lever, .. } = found;
        WallContact { body, wall, separation, normal, lever, surface }
    }

    /// The contact point on the body's surface, in space. `bodies` are those that the contact was found in.
    ///
    /// # Panics
    /// If `bodies` has fewer bodies than that.
    pub fn point(&self, bodies: &Bodies) -> DVec3 {
        bodies.position[self.body] + self.lever
    }
}

/// The surfaces of all walls of a scene at one time, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walls {
    surfaces: Vec<Surface>,
    /// The place of each one's wall in the scene's list.
    wall: Vec<usize>,
    /// Its own coefficient of friction.
    friction: Vec<Option<f64>>,
    /// The surfaces that move.
    moving: Vec<Moving>,
    /// Those that loads move.
    loaded: Vec<Loaded>,
}

/// A surface that moves.
#[derive(Clone, Debug, PartialEq)]
struct Moving {
    /// Its place among the surfaces.
    at: usize,
    /// Where it is at time 0.
    given: Surface,
    wall: Wall,
}

impl Walls {
    /// The surfaces of these walls at time 0; in the plane those that bodies can meet.
    pub fn new(all: &[Wall], planar: bool) -> Walls {
        Walls::in_space(all, planar, &Periods::NONE)
    }

    /// The same in a space with periods, over which pressures are taken.
    pub fn in_space(all: &[Wall], planar: bool, periods: &Periods) -> Walls {
        let mut walls = Walls::default();
        for (index, wall) in all.iter().enumerate() {
            let first = walls.surfaces.len();
            walls.surfaces.extend(wall.surfaces(planar));
            if wall.motion().is_some() {
                let moving = |(at, given): (usize, &Surface)| Moving { at: first + at, given: *given, wall: *wall };
                walls.moving.extend(walls.surfaces[first..].iter().enumerate().map(moving));
            }
            walls.loaded.extend(wall.loaded(first, periods, planar));
            walls.wall.resize(walls.surfaces.len(), index);
            walls.friction.resize(walls.surfaces.len(), wall.friction());
        }
        walls
    }

    /// The same walls where they are at `time`.
    ///
    /// ```
    /// use relcp::walls::{Wall, WallMotion, Walls};
    /// let motion = Some(WallMotion::new([0.5, 0.0, 0.0]));
    /// let piston = Wall::HalfSpace { normal: [1.0, 0.0, 0.0], offset: 0.0, motion, friction: None, load: None };
    /// let walls = Walls::new(&[piston], false);
    /// assert!(walls.move_in_time() && walls.at(0.0) == walls && walls.at(2.0) != walls);
    /// ```
    pub fn at(&self, time: f64) -> Walls {
        let mut walls = self.clone();
        for Moving { at, given, wall } in &self.moving {
            if let Some(moved) = wall.moved(time) {
                walls.surfaces[*at] = moved.surface(given);
            }
        }
        walls
    }

    /// The velocity of the place `point` of a surface over the time `from` to `to`, at whose end it is there.
    ///
    /// ```
    /// use glam::DVec3;
    /// use relcp::walls::{Wall, WallMotion, Walls};
    /// let motion = Some(WallMotion::new([0.5, 0.0, 0.0]));
    /// let belt = Wall::HalfSpace { normal: [0.0, 0.0, 1.0], offset: 0.0, motion, friction: None, load: None };
    /// let velocity = Walls::new(&[belt], false).velocity(0, DVec3::ZERO, [1.0, 1.5]);
    /// assert!(velocity.abs_diff_eq(DVec3::new(0.5, 0.0, 0.0), 1e-15));
    /// ```
    pub fn velocity(&self, surface: usize, point: DVec3, [from, to]: [f64; 2]) -> DVec3 {
        let Some(moving) = self.moving.iter().find(|moving| moving.at == surface) else { return DVec3::ZERO };
        let (Some(before), Some(after)) = (moving.wall.moved(from), moving.wall.moved(to)) else { return DVec3::ZERO };
        (point - before.point(after.back(point))) / (to - from)
    }

    /// The own coefficient of friction of the wall of each surface, where it has one.
    pub fn frictions(&self) -> &[Option<f64>] {
        &self.friction
    }

    /// Whether any of them has a motion or a load.
    pub fn move_in_time(&self) -> bool {
        !self.moving.is_empty() || !self.loaded.is_empty()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.surfaces.is_empty()
    }

    /// Puts a surface elsewhere.
    pub(crate) fn set(&mut self, at: usize, surface: Surface) {
        self.surfaces[at] = surface;
    }

    /// How many surfaces there are.
    pub fn len(&self) -> usize {
        self.surfaces.len()
    }

    /// Whether no body can leave, as the walls stand: they and the periods leave no direction to go for ever.
    ///
    /// ```
    /// use relcp::periodic::Periods;
    /// use relcp::walls::{Wall, Walls};
    /// let (center, normal) = ([0.0; 3], [0.0, 1.0, 0.0]);
    /// let channel = Wall::Channel { center, normal, width: 2.0, motion: None, friction: None };
    /// let walls = Walls::new(&[channel], true);
    /// assert!(!walls.are_closed(&Periods::default(), true));
    /// assert!(walls.are_closed(&Periods::new([Some(9.0), None, None]), true));
    /// ```
    pub fn are_closed(&self, periods: &Periods, planar: bool) -> bool {
        let periodic = DVec3::AXES.into_iter().zip(periods.lengths()).filter(|(_, length)| length.is_some());
        let closed: Vec<DVec3> = periodic.map(|(axis, _)| axis).chain(planar.then_some(DVec3::Z)).collect();
        enclosure::is_closed(&self.surfaces, &closed)
    }

    /// A box along the axes that contains all that the walls leave of space, with its least corner first: in a periodic
    /// scene of one cell. `plane` is the z of a planar scene. None where they leave nothing, or a way to infinity.
    ///
    /// ```
    /// use glam::DVec3;
    /// use relcp::periodic::Periods;
    /// use relcp::walls::{Wall, Walls};
    /// let sphere = Wall::Sphere { center: [1.0, 2.0, 0.0], radius: 3.0, motion: None, friction: None };
    /// let extent = Walls::new(&[sphere], false).extent(&Periods::NONE, None);
    /// assert_eq!(extent, Some([DVec3::new(-2.0, -1.0, -3.0), DVec3::new(4.0, 5.0, 3.0)]));
    /// assert_eq!(Walls::default().extent(&Periods::NONE, None), None);
    /// ```
    pub fn extent(&self, periods: &Periods, plane: Option<f64>) -> Option<[DVec3; 2]> {
        let closed = self.are_closed(periods, plane.is_some());
        closed.then(|| enclosure::extent(&self.surfaces, &periods.lengths(), plane)).flatten()
    }

    /// The surfaces, in order.
    #[doc(hidden)]
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The place in the scene's list of the wall that a surface is of.
    pub fn wall_of(&self, surface: usize) -> usize {
        self.wall[surface]
    }

    /// Which of the surfaces of its wall a surface is, from 0.
    pub fn face_of(&self, surface: usize) -> usize {
        self.wall[..surface].iter().rev().take_while(|wall| **wall == self.wall[surface]).count()
    }

    /// How far a body reaches past the walls, and past which one most; none where it is inside of all.
    pub fn deepest(&self, body: &Placed) -> Option<(f64, usize)> {
        let deeper = |deepest: Option<(f64, usize)>, (surface, wall): (&Surface, &usize)| {
            // Not a number counts as outside.
            if surface.bound(body) >= 0.0 {
                return deepest;
            }
            let depth = -surface.separation(body).separation;
            if depth <= deepest.map_or(0.0, |(depth, _)| depth) { deepest } else { Some((depth, *wall)) }
        };
        self.surfaces.iter().zip(&self.wall).fold(None, deeper)
    }

    /// Every body and surface whose separation is at most `cutoff`, sorted by body, then surface, computed afresh from
    /// the bodies alone: it audits the steps.
    pub fn contacts(&self, bodies: &Bodies, cutoff: f64) -> Vec<WallContact> {
        let of_body = |body: usize| {
            let placed = bodies.placed(body);
            let surfaces = self.surfaces.iter().enumerate();
            surfaces
                .filter(|(_, surface)| surface.bound(&placed) <= cutoff)
                .map(|(at, surface)| WallContact::new(body, [self.wall[at], at], surface.separation(&placed)))
                .filter(|contact| contact.separation <= cutoff)
                .collect::<Vec<_>>()
        };
        if self.is_empty() {
            return Vec::new();
        }
        (0..bodies.len()).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).flat_map_iter(of_body).collect()
    }

    /// Every body and surface that a bound does not keep apart by more than `cutoff`, sorted by body, then surface.
    #[cfg(feature = "gpu")]
    pub(crate) fn candidates(&self, bodies: &Bodies, cutoff: f64) -> Vec<[usize; 2]> {
        let of_body = |body: usize| {
            let placed = bodies.placed(body);
            let near = move |(_, surface): &(usize, &Surface)| surface.bound(&placed) <= cutoff;
            self.surfaces.iter().enumerate().filter(near).map(move |(at, _)| [body, at])
        };
        (0..bodies.len()).flat_map(of_body).collect()
    }

    /// How far the body that is farthest outside reaches past a wall; zero where all are inside.
    pub fn max_overlap(&self, bodies: &Bodies) -> f64 {
        self.contacts(bodies, 0.0).iter().fold(0.0, |worst, contact| {
            let depth = -contact.separation;
            if depth > worst { depth } else { worst }
        })
    }
}
