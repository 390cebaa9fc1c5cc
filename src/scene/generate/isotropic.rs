//! Random sequential placement: uniform centres, isotropic rotations, a draw that overlaps an earlier body is repeated.
//! In a planar scene a body's axis z lies in the plane, in a uniform direction, with the orientation that
//! `bodies[].angle` gives. Inside a region or walls centres are uniform in a box about these, and a draw that reaches
//! past one of their surfaces is repeated too.

use super::super::Generate;
use super::super::error::{FaultKind, SceneError};
use super::super::orientation::ALONG_X;
use super::occupied::{Occupied, capsule, capsule_of};
use super::room::Room;
use crate::bodies::Bodies;
use crate::periodic::Periods;
use crate::separation::Placed;
use crate::shape::{Centreline, Geometry, Shape};
use crate::walls::Walls;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Draws of one body before placement counts as failed; at the largest accepted volume fraction the worst body needs
/// less than a two-hundredth of this (tested).
const MAX_DRAWS: u64 = 1_000_000;
/// Draws of all bodies inside a region before placement counts as failed: those of the worst body, and so many a body.
/// At the volume fraction that is accepted elsewhere bodies need some dozens each.
const DRAWS_A_BODY: u64 = 5_000;
/// Draws between two calls of `goes_on`: some milliseconds.
const DRAWS_A_QUESTION: u64 = 2_048;
/// The random stream of the first rule; the streams below belong to dividing bodies, whose ids stay below 2^53.
const FIRST_STREAM: u64 = 1 << 63;

/// The random numbers of a rule: the same whatever other rules draw.
pub(super) fn stream(seed: u64, rule: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(FIRST_STREAM + rule as u64);
    random
}

/// The bodies to place.
pub(super) struct Order {
    /// The number of bodies of each shape; several shapes are mixed.
    pub components: Vec<(u64, Shape)>,
    /// Their volume over that of the space in which they are placed; none where their number determines it: in a whole
    /// periodic cell, and inside a region.
    pub volume_fraction: Option<f64>,
    /// The middle of this space.
    pub center: DVec3,
    /// The region that bodies are wholly inside of; none for a box.
    pub inside: Option<Inside>,
    pub planar: bool,
    pub seed: u64,
    pub rule: usize,
}

/// A region that bodies are placed in, by the box about it and the walls.
#[derive(Clone, Copy)]
pub(super) struct Inside {
    pub sides: DVec3,
    /// Whether it is the rule's own region, not the walls alone.
    pub is_own: bool,
}

impl Order {
    /// Draws of all bodies before placement counts as failed.
    fn most_draws(&self) -> u64 {
        let all = MAX_DRAWS.saturating_add(DRAWS_A_BODY.saturating_mul(self.count()));
        if self.inside.is_some() { all } else { u64::MAX }
    }

    pub fn count(&self) -> u64 {
        self.components.iter().map(|(count, _)| count).sum()
    }

    /// The volume of all bodies; in a planar scene the area.
    pub fn volume(&self) -> f64 {
        self.components.iter().map(|(count, shape)| *count as f64 * volume(shape, self.planar)).sum()
    }

    /// The components in order of placement, those with the largest bounding capsules first: small bodies fit between
    /// large ones.
    fn largest_first(&self) -> Vec<usize> {
        let size = |of: usize| capsule_of(&self.components[of].1).0.volume();
        let mut numbers: Vec<usize> = (0..self.components.len()).collect();
        numbers.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
        numbers
    }
}

/// Places the bodies inside the walls and their region, which is the last of `walls`, without overlap with earlier
/// bodies and their images. `groups` has the group of each component.
pub(super) fn add(
    order: &Order,
    walls: &Walls,
    bodies: &mut Bodies,
    groups: &[u32],
    goes_on: &mut dyn FnMut(usize) -> bool,
) -> Result<(), SceneError> {
    let mut random = stream(order.seed, order.rule);
    let sides = sides(order, bodies.periods);
    let room = Room { order, sides, periodic: bodies.periods.lengths().map(|length| length.is_some()), walls };
    room.check()?;
    let mut occupied = Occupied::new(bodies.periods);
    for i in 0..bodies.len() {
        occupied.insert(capsule(&bodies.shape[i], bodies.position[i], bodies.orientation[i]));
    }
    let (mut draws, mut done, most_draws) = (0, 0, order.most_draws());
    let mut placed = vec![Vec::new(); order.components.len()];
    for component in order.largest_first() {
        let (count, shape) = order.components[component];
        for _ in 0..count {
            let mut going = true;
            let mut asked = || {
                draws += 1;
                going = draws % DRAWS_A_QUESTION != 0 || goes_on(bodies.len() + done as usize);
                going && draws <= most_draws
            };
            let free = |body: &Placed| {
                !occupied.overlaps(&capsule(&shape, body.position, body.orientation)) && walls.deepest(body).is_none()
            };
            let Some((body, _)) = place(order, shape, sides, &free, &mut random, &mut asked) else {
                return Err(if going { room.full(done) } else { stopped(order, done) });
            };
            occupied.insert(capsule(&shape, body.position, body.orientation));
            placed[component].push(body);
            done += 1;
        }
    }
    for (of_component, group) in placed.into_iter().zip(groups) {
        for body in of_component {
            bodies.push(body, *group);
        }
    }
    Ok(())
}

fn stopped(order: &Order, done: u64) -> SceneError {
    let message = format!("stopped after {done} of {} bodies were placed", order.count());
    SceneError::new(FaultKind::Interrupted, format!("generate.{}.isotropic", order.rule), message)
}

/// A body whose capsule is `free`, and the number of draws; none if there is none in [`MAX_DRAWS`], or if `goes_on`,
/// which is called before each draw, returns false.
fn place(
    order: &Order,
    shape: Shape,
    sides: DVec3,
    free: &dyn Fn(&Placed) -> bool,
    random: &mut ChaCha8Rng,
    goes_on: &mut dyn FnMut() -> bool,
) -> Option<(Placed, u64)> {
    (1..=MAX_DRAWS).take_while(|_| goes_on()).find_map(|draws| {
        let mut position = order.center + sides * (DVec3::from_array(random.random::<[f64; 3]>()) - 0.5);
        let lies = order.planar && !matches!(shape, Shape::Sphere { .. });
        let orientation = if lies { rotation_in_plane(random) } else { rotation(random) };
        if order.planar {
            position.z = 0.0;
        }
        let body = Placed { shape, position, orientation };
        free(&body).then_some((body, draws))
    })
}

/// Sides of the box (in a planar scene, of the rectangle) that contains the centres: the periods, and the same length
/// along all open axes.
pub(super) fn sides(order: &Order, periods: Periods) -> DVec3 {
    if let Some(Inside { sides, .. }) = order.inside {
        return sides;
    }
    // A rule without a fraction fills a whole cell, which has no open axis.
    let whole = order.volume() / order.volume_fraction.unwrap_or(1.0);
    let open = |axis: usize| periods.lengths()[axis].is_none() && !(order.planar && axis == 2);
    let others: f64 = periods.lengths().into_iter().flatten().product();
    let side = match (0..3).filter(|axis| open(*axis)).count() {
        3 => whole.cbrt(),
        2 => (whole / others).sqrt(),
        _ => whole / others,
    };
    DVec3::from_array(periods.lengths().map(|length| length.unwrap_or(side)))
}

/// The total volume of a rule's bodies, for a volume fraction.
pub(in super::super) fn volume_of_all(rule: &Generate, planar: bool) -> f64 {
    rule.components().map(|(count, shape, _)| count as f64 * volume(&shape, planar)).sum()
}

/// The volume that counts for a volume fraction; in a planar scene the area of the section with the plane.
pub(super) fn volume(shape: &Shape, planar: bool) -> f64 {
    if !planar {
        return shape.volume();
    }
    match shape.geometry() {
        Geometry::Centreline { curve: Centreline::Segment { half }, radius } => {
            PI * radius * radius + 4.0 * half * radius
        }
        // A ring is perpendicular to the plane and intersects it in two discs.
        Geometry::Centreline { curve: Centreline::Circle { .. }, radius } => 2.0 * PI * radius * radius,
        Geometry::Ellipsoid { radii } => PI * radii.y * radii.z,
        // A custom shape counts as its bounding disc.
        Geometry::Centreline { curve: Centreline::Point, .. } | Geometry::Convex(_) => {
            PI * shape.bounding_radius().powi(2)
        }
    }
}

/// An isotropic rotation: a uniform point of the three-sphere, from two uniform points of the disc (Marsaglia 1972).
/// It needs only square roots, which have the same bits on every machine.
pub(super) fn rotation(random: &mut ChaCha8Rng) -> DQuat {
    let mut disc = || {
        loop {
            let [x, y] = random.random::<[f64; 2]>().map(|u| 2.0 * u - 1.0);
            let square = x * x + y * y;
            if square < 1.0 && square > 0.0 {
                return (x, y, square);
            }
        }
    };
    let ((x, y, first), (z, w, second)) = (disc(), disc());
    let scale = ((1.0 - first) / second).sqrt();
    DQuat::from_xyzw(x, y, scale * z, scale * w).normalize()
}

/// The same in the plane: z along x, turned about the plane's normal by a uniform angle. Half of it is that of a
/// uniform point of the disc.
pub(super) fn rotation_in_plane(random: &mut ChaCha8Rng) -> DQuat {
    loop {
        let [x, y] = random.random::<[f64; 2]>().map(|u| 2.0 * u - 1.0);
        let square = x * x + y * y;
        if square < 1.0 && square > 0.0 {
            let length = square.sqrt();
            return (DQuat::from_xyzw(0.0, 0.0, y / length, x / length) * ALONG_X).normalize();
        }
    }
}

/// The largest accepted volume fraction of bounding capsules, by their length over their diameter.
///
/// Measured with 4,000 bodies, until one needed more than 1,500 draws: 0.32 at aspect 1, 0.30 at 2, 0.27 at 3, 0.23 at
/// 5, 0.18 at 10 and 0.10 at
/// 20. This curve stays below all of them.
fn capsule_fraction(aspect: f64) -> f64 {
    2.4 / (aspect + 6.5)
}

/// The same for discs in a plane, whose random placement jams at 0.547.
const DISC_FRACTION: f64 = 0.45;

/// The same for capsules in a plane, by their length over their width. Measured likewise, with 200 to 400 bodies:
/// 0.47 at aspect 1 to 3, 0.42 at 5, 0.35 at 10, 0.26 at 20, 0.17 at 50 and 0.09 at 100.
fn lying_fraction(aspect: f64) -> f64 {
    DISC_FRACTION.min(8.5 / (aspect + 16.5))
}

/// The section of a shape's bounding capsule with the plane: its length and its width.
fn lying_capsule(shape: &Shape) -> [f64; 2] {
    let (capsule, axis) = capsule_of(shape);
    let width = capsule.thickness();
    // If the capsule's axis is the body's x, it is perpendicular to the plane.
    [if axis == DVec3::X { width } else { capsule.major_axis() }, width]
}

/// Largest volume fraction (of a planar scene, area fraction) that is accepted for all bodies of a rule: each component
/// uses up its share of the fraction that it may have alone. Small bodies between large ones reach more (tested).
pub(in super::super) fn reachable_by_all(rule: &Generate, planar: bool) -> f64 {
    let limit = |shape: &Shape| reachable_fraction(shape, planar);
    let components: Vec<_> = rule.components().collect();
    if let [(_, shape, _)] = &components[..] {
        return limit(shape);
    }
    let taken = components.iter().map(|(count, shape, _)| *count as f64 * volume(shape, planar) / limit(shape));
    volume_of_all(rule, planar) / taken.sum::<f64>()
}

/// Largest volume fraction (of a planar scene, area fraction) that is accepted for a shape.
pub(super) fn reachable_fraction(shape: &Shape, planar: bool) -> f64 {
    if planar {
        let [length, width] = lying_capsule(shape);
        let area = width * (length - width) + 0.25 * PI * width * width;
        return lying_fraction(length / width) * volume(shape, true) / area;
    }
    let (capsule, _) = capsule_of(shape);
    capsule_fraction(capsule.major_axis() / capsule.thickness()) * shape.volume() / capsule.volume()
}

#[cfg(test)]
mod tests {
    use super::super::super::Component;
    use super::*;

    /// Draws that the worst body needs at the largest volume fraction.
    fn worst_draws(components: &[(u64, Shape)], planar: bool) -> u64 {
        let mut rule = Generate::isotropic(components[0].0, components[0].1, None);
        if let Generate::Isotropic { mixture, .. } = &mut rule {
            *mixture = components[1..].iter().map(|(count, shape)| Component::new(*count, *shape)).collect();
        }
        let volume_fraction = Some(reachable_by_all(&rule, planar));
        let components = components.to_vec();
        let order = Order { components, volume_fraction, center: DVec3::ZERO, inside: None, planar, seed: 1, rule: 0 };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let (sides, mut occupied, mut worst) = (sides(&order, Periods::NONE), Occupied::default(), 0);
        for component in order.largest_first() {
            let (count, shape) = order.components[component];
            for _ in 0..count {
                let taken = |body: &Placed| capsule(&shape, body.position, body.orientation);
                let free = |body: &Placed| !occupied.overlaps(&taken(body));
                let (body, draws) = place(&order, shape, sides, &free, &mut random, &mut || true).unwrap();
                occupied.insert(taken(&body));
                worst = worst.max(draws);
            }
        }
        worst
    }

    fn rod(length: f64) -> Shape {
        Shape::Spherocylinder { diameter: 1.0, length }
    }

    #[test]
    fn the_largest_accepted_fraction_is_reached_easily() {
        for (shape, count) in [
            (Shape::Sphere { radius: 0.5 }, 3000),
            (rod(2.0), 3000),
            (rod(5.0), 2000),
            (rod(10.0), 2000),
            (rod(30.0), 1000),
            (rod(100.0), 500),
            (Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }, 2000),
            (Shape::Ellipsoid { radii: [2.0, 0.2, 1.0] }, 1000),
            (Shape::Torus { major_radius: 1.0, minor_radius: 0.1 }, 1000),
        ] {
            let worst = worst_draws(&[(count, shape)], false);
            assert!(worst < MAX_DRAWS / 200, "{shape:?}: {worst} draws");
        }
        for (shape, count) in [
            (Shape::Sphere { radius: 0.5 }, 3000),
            (rod(2.0), 2000),
            (rod(5.0), 1000),
            (rod(10.0), 1000),
            (rod(30.0), 600),
            (rod(100.0), 300),
            (Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }, 2000),
            (Shape::Ellipsoid { radii: [3.0, 1.0, 2.0] }, 2000),
            (Shape::Ellipsoid { radii: [0.2, 2.0, 1.0] }, 1000),
            (Shape::Torus { major_radius: 1.0, minor_radius: 0.1 }, 2000),
        ] {
            let worst = worst_draws(&[(count, shape)], true);
            assert!(worst < MAX_DRAWS / 200, "in the plane {shape:?}: {worst} draws");
        }
    }

    #[test]
    fn the_largest_accepted_fraction_of_a_mixture_is_reached_easily() {
        let ball = |radius: f64| Shape::Sphere { radius };
        for components in [
            vec![(1000, ball(0.5)), (100, ball(1.0))],
            vec![(3000, ball(0.1)), (30, ball(0.5))],
            vec![(1000, ball(0.5)), (200, rod(10.0))],
            vec![(200, ball(3.0)), (300, rod(30.0)), (1000, rod(3.0))],
            vec![(300, Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }), (300, rod(20.0)), (300, ball(0.2))],
        ] {
            for planar in [false, true] {
                let worst = worst_draws(&components, planar);
                assert!(worst < MAX_DRAWS / 200, "{components:?}, planar {planar}: {worst} draws");
            }
        }
    }
}
