//! Bodies of one shape, bonded end to end: straight, as a ring, along a line, or as a random walk.
//!
//! A bond holds the end of a body's axis and the start of the next one's at its rest length. All paths keep it exactly.

use super::super::Scene;
use super::super::error::{FaultKind, SceneError};
use super::super::orientation::{ALONG_X, along};
use super::copied::offsets;
use super::walk::Walk;
use super::{Chain, ChainPath, GoesOn};
use crate::bodies::Bodies;
use crate::dynamics::{Bending, Bond};
use crate::separation::Placed;
use crate::shape::Shape;
use crate::walls::Walls;
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// The default gap between neighbours, in thicknesses of a body. Caps of radius `r` whose tips are `g` apart touch at
/// the bend `2 acos(1 - g / 2 r)`: 74 degrees.
const GAP: f64 = 0.2;
/// The default of the largest bend of a random walk, degrees: below the one at which neighbours touch.
const DEFAULT_BEND: f64 = 60.0;

/// From a body's centre to each end of its axis, where bonds are: zero for a ball. None for shapes without ends.
pub(in super::super) fn reach(shape: &Shape) -> Option<f64> {
    match *shape {
        Shape::Sphere { .. } => Some(0.0),
        Shape::Spherocylinder { length, .. } => Some(0.5 * length),
        Shape::Ellipsoid { radii } => Some(radii[2]),
        _ => None,
    }
}

/// The axis of its bodies, along which they are bonded.
const AXIS: [f64; 3] = [0.0, 0.0, 1.0];

/// The lengths of a chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Links {
    /// From a body's centre to each of its ends.
    pub reach: f64,
    /// The rest length of bonds.
    pub rest: f64,
}

impl Links {
    fn of(chain: &Chain) -> Links {
        let thickness = chain.shape.thickness();
        let gap = chain.gap.unwrap_or(GAP * thickness);
        let reach = reach(&chain.shape).unwrap_or(0.0);
        // Bonds of balls end at their centres.
        Links { reach, rest: if reach == 0.0 { thickness + gap } else { gap } }
    }

    /// The distance between the centres of neighbours in a straight chain.
    fn pitch(self) -> f64 {
        2.0 * self.reach + self.rest
    }
}

/// A link of a chain: its centre, and the unit direction of its axis towards the next one.
pub(super) type Link = (DVec3, DVec3);

/// Where a chain is placed.
pub(super) struct Place<'a> {
    pub scene: &'a Scene,
    pub walls: &'a Walls,
    pub rule: usize,
    pub group: u32,
}

impl Place<'_> {
    pub fn fault(&self, kind: FaultKind, key: &str, message: String) -> SceneError {
        SceneError::new(kind, format!("generate.{}.chain.{key}", self.rule), message)
    }

    /// A link as a body.
    pub fn body(&self, shape: Shape, (position, direction): Link) -> Placed {
        Placed { shape, position, orientation: oriented(direction, self.scene.planar) }
    }
}

/// The rotation that takes body z to a direction; in the plane the one that `bodies[].angle` gives.
fn oriented(direction: DVec3, planar: bool) -> DQuat {
    if planar { DQuat::from_rotation_z(direction.y.atan2(direction.x)) * ALONG_X } else { along(direction) }
}

/// The bonds of a rule whose first body has the index `first`.
pub(in super::super) fn bonds(chain: &Chain, first: usize) -> Vec<Bond> {
    let Links { reach, rest } = Links::of(chain);
    let count = chain.count as usize;
    let of_chain = |start: usize| {
        let last = if matches!(chain.path, Some(ChainPath::Ring { .. })) { count } else { count - 1 };
        (0..last).map(move |i| [start + i, start + (i + 1) % count])
    };
    let starts = (0..super::copied::copies(&chain.repeat) as usize).map(|copy| first + copy * count);
    let bending = chain.bending.map(|stiffness| Bending { axes: Some([AXIS; 2]), ..Bending::new(stiffness) });
    let bond = |bodies: [usize; 2]| Bond {
        length: rest,
        bending,
        break_force: chain.break_force,
        contact: chain.contact,
        ..Bond::new(bodies, [[0.0, 0.0, reach], [0.0, 0.0, 0.0 - reach]], chain.stiffness)
    };
    starts.flat_map(of_chain).map(bond).collect()
}

/// Places the chain and its copies, one after another.
pub(super) fn add(chain: &Chain, place: &Place, bodies: &mut Bodies, goes_on: GoesOn) -> Result<(), SceneError> {
    let (links, count) = (Links::of(chain), chain.count as usize);
    let straight = ChainPath::Straight { center: [0.0; 3], axis: [1.0, 0.0, 0.0] };
    let one = match chain.path.as_ref().unwrap_or(&straight) {
        ChainPath::Straight { center, axis } => straight_links(count, links, (*center).into(), (*axis).into()),
        ChainPath::Ring { center } => ring_links(count, links, (*center).into()),
        ChainPath::Along { points } => links_along(count, links, points, place)?,
        ChainPath::RandomWalk { start, largest_bend } => {
            let bend = largest_bend.unwrap_or(DEFAULT_BEND).to_radians();
            let mut walk = Walk::new(place, links, chain, bend, bodies);
            for offset in offsets(&chain.repeat) {
                for link in walk.links(DVec3::from(*start) + offset, goes_on)? {
                    bodies.push(place.body(chain.shape, link), place.group);
                }
            }
            return Ok(());
        }
    };
    for offset in offsets(&chain.repeat) {
        for (position, direction) in &one {
            bodies.push(place.body(chain.shape, (*position + offset, *direction)), place.group);
        }
    }
    Ok(())
}

fn straight_links(count: usize, links: Links, center: DVec3, axis: DVec3) -> Vec<Link> {
    let axis = axis.normalize_or(DVec3::X);
    let at = |i: usize| center + links.pitch() * (i as f64 - 0.5 * (count - 1) as f64) * axis;
    (0..count).map(|i| (at(i), axis)).collect()
}

/// A regular polygon, a body in the middle of each side. Ends that are `a` from a corner are `2 a cos(pi / n)` apart.
fn ring_links(count: usize, links: Links, center: DVec3) -> Vec<Link> {
    let half_angle = PI / count as f64;
    let half_side = links.reach + 0.5 * links.rest / half_angle.cos();
    let inner_radius = half_side / half_angle.tan();
    let link = |i: usize| {
        let (sine, cosine) = (TAU * i as f64 / count as f64).sin_cos();
        (center + inner_radius * DVec3::new(cosine, sine, 0.0), DVec3::new(-sine, cosine, 0.0))
    };
    (0..count).map(link).collect()
}

/// Bodies and bonds in turn, each the chord of a line from where the last one ended.
fn links_along(count: usize, links: Links, points: &[[f64; 3]], place: &Place) -> Result<Vec<Link>, SceneError> {
    let corners: Vec<DVec3> = points.iter().copied().map(DVec3::from).collect();
    let mut at = OnLine { corner: 0, point: corners[0] };
    let mut found = Vec::new();
    while found.len() < count {
        let next = if found.is_empty() { Some(at) } else { at.forward(&corners, links.rest) };
        let ends = next.and_then(|start| Some([start, start.forward(&corners, 2.0 * links.reach)?]));
        let Some([start, end]) = ends else {
            let message = format!("the line holds {} of {count} bodies; make it longer", found.len());
            return Err(place.fault(FaultKind::Placement, "path.along.points", message));
        };
        let ahead = corners[end.corner + 1] - corners[end.corner];
        let direction = (end.point - start.point).normalize_or(ahead.normalize_or(DVec3::X));
        found.push((0.5 * (start.point + end.point), direction));
        at = end;
    }
    Ok(found)
}

/// A point of a line, on the segment after a corner.
#[derive(Clone, Copy)]
struct OnLine {
    corner: usize,
    point: DVec3,
}

impl OnLine {
    /// The next point of the line at a distance from this one.
    fn forward(self, corners: &[DVec3], distance: f64) -> Option<OnLine> {
        if distance == 0.0 {
            return Some(self);
        }
        for corner in self.corner..corners.len() - 1 {
            let start = if corner == self.corner { self.point } else { corners[corner] };
            let (from, way) = (start - self.point, corners[corner + 1] - start);
            // |from + t way| = distance, where the line leaves the sphere.
            let (a, b, c) = (way.length_squared(), from.dot(way), from.length_squared() - distance * distance);
            let t = (-b + (b * b - a * c).max(0.0).sqrt()) / a;
            if c <= 0.0 && t <= 1.0 {
                return Some(OnLine { corner, point: start + t * way });
            }
        }
        None
    }
}
