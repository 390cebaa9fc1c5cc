//! Tubes and channels as wide as the bodies in them, along random axes, open, closed or with a piston.

use super::super::{Drawn, drive, room};
use super::parts::{Closing, along, described, scene};
use crate::hard::start::{Random, body, ellipsoid, moving, ring, rod, sphere};
use glam::DVec3;
use relcp::scene::{Body, Drag, Dynamics, Force, Scene, Wall};
use relcp::shape::Shape;

/// Bodies of a tube.
const COUNT: [f64; 2] = [1.0, 9.0];
/// Half their width.
const RADIUS: [f64; 2] = [0.25, 1.0];
/// Lengths over widths.
const LONG: [f64; 2] = [1.0, 6.0];
/// The probability of no slack.
const SNUG: f64 = 0.6;
/// Slacks, as parts of the width.
const SLACK: [f64; 2] = [1e-12, 1e-2];
/// Gaps between bodies, in their lengths.
const MOST_GAP: f64 = 0.3;
/// The range of the driven distance of a body in a step, relative to its width.
const DRIVEN: [f64; 2] = [1e-3, 0.1];
/// The range of a piston's path, relative to the tube's length.
const SHORTER: [f64; 2] = [0.05, 0.6];

pub(super) fn draw(random: &mut Random, name: &str) -> Drawn {
    let planar = random.chance(0.3);
    let radius = random.log_within(RADIUS[0], RADIUS[1]);
    let (shapes, what) = members(random, radius, planar);
    let way = room::direction(random, planar);
    let count = random.log_within(COUNT[0], COUNT[1]).floor() as usize;
    let (places, half) = places(random, &shapes, count);
    let shorter = random.within(SHORTER[0], SHORTER[1]) * 2.0 * half;
    let thinnest = shapes.iter().map(Shape::thickness).fold(f64::INFINITY, f64::min);
    let closing = Closing::draw(random, shorter, thinnest, count);
    let (mut scene, settings) = scene(random, name, planar, &closing, thinnest);
    let slack = random.log_within(SLACK[0], SLACK[1]);
    let slack = random.either(SNUG, 0.0, slack);
    let centre = half * random.vector();
    let centre = if planar { centre.with_z(0.0) } else { centre };
    let tube = (way, centre, 2.0 * radius * (1.0 + slack));
    let (side, in_what) = side(random, tube, planar);
    let (ends, ended) = ends(random, &closing, (way, centre), half);
    scene.walls = [side].into_iter().chain(ends).collect();
    let placed = |(shape, at): &(Shape, f64)| body(*shape, (centre + *at * way).to_array(), along(way, planar));
    scene.bodies = places.iter().map(placed).collect();
    drive_along(random, &mut scene, way, radius);
    let driven = random.chance(0.2).then(|| drive::drive(random, &mut scene, 0.5 * radius));
    let slack = if slack > 0.0 { format!("slack {slack:.0e}") } else { "without slack".into() };
    let what = format!("{count} {what} in {in_what} {slack}{ended}");
    Drawn { what: described(&scene, &what, driven.as_deref().unwrap_or(""), &settings), scene }
}

/// Shapes of this half width, along z.
fn members(random: &mut Random, radius: f64, planar: bool) -> (Vec<Shape>, &'static str) {
    let long = radius * random.within(LONG[0], LONG[1]);
    let (ball, bar, egg) = (sphere(radius), rod(2.0 * radius, 2.0 * long), ellipsoid([radius, radius, long]));
    match random.below(if planar { 4 } else { 5 }) {
        0 => (vec![ball], "balls"),
        1 => (vec![bar], "rods"),
        2 => (vec![ball, bar], "balls and rods"),
        3 => (vec![egg], "ellipsoids"),
        _ => {
            let minor = radius * random.within(0.05, 0.3);
            (vec![ring(radius - minor, minor)], "rings")
        }
    }
}

/// Places of bodies along the axis, one after another about the middle, and half the length that they take.
fn places(random: &mut Random, shapes: &[Shape], count: usize) -> (Vec<(Shape, f64)>, f64) {
    let mut end = 0.0;
    let mut places = Vec::new();
    for _ in 0..count {
        let shape = shapes[random.below(shapes.len())];
        let length = match shape {
            Shape::Torus { minor_radius, .. } => 2.0 * minor_radius,
            _ => shape.major_axis(),
        };
        let gap = random.within(0.0, MOST_GAP) * length;
        end += random.either(0.5, 0.0, gap);
        places.push((shape, end + 0.5 * length));
        end += length;
    }
    places.iter_mut().for_each(|(_, at)| *at -= 0.5 * end);
    (places, 0.5 * end)
}

/// A wall around an axis, at both sides of it or all around.
fn side(random: &mut Random, (way, centre, width): (DVec3, DVec3, f64), planar: bool) -> (Wall, &'static str) {
    let normal = room::across(random, way, planar).to_array();
    if planar || random.chance(0.3) {
        return (Wall::Channel { normal, center: centre.to_array(), width, motion: None, friction: None }, "a channel");
    }
    let wall = Wall::Cylinder {
        center: centre.to_array(),
        axis: way.to_array(),
        radius: 0.5 * width,
        length: None,
        motion: None,
        friction: None,
    };
    (wall, "a tube")
}

/// Draws the ends of the axis: nothing, a floor, or a piston.
fn ends(random: &mut Random, closing: &Closing, (way, centre): (DVec3, DVec3), half: f64) -> (Vec<Wall>, &'static str) {
    let middle = way.dot(centre);
    let piston = closing.wall(way, half - middle);
    let floor = room::floor(-way, half + middle);
    match random.below(4) {
        0 => (Vec::new(), ""),
        1 => (vec![floor], ", closed at one end"),
        2 => (vec![piston], ", pushed by a piston"),
        _ => (vec![piston, floor], ", closed by a piston"),
    }
}

/// Speeds along the axis and a little aside, and forces.
fn drive_along(random: &mut Random, scene: &mut Scene, way: DVec3, radius: f64) {
    let dt = scene.time.dt;
    let step = random.log_within(DRIVEN[0], DRIVEN[1]) * radius;
    let aside = random.log_within(1e-6, 0.3) * random.vector();
    let aside = if scene.planar { aside.with_z(0.0) } else { aside };
    let towards = (way + random.either(0.5, DVec3::ZERO, aside)).normalize();
    match scene.dynamics {
        Dynamics::Overdamped { drag: Drag::Even(drag) } => {
            let force = (drag * 2.0 * radius * step / dt * towards).to_array();
            scene.forces.push(Force::Uniform { force, group: None, window: None });
        }
        _ => {
            let speed = |random: &mut Random| random.within(-1.0, 1.0) * step / dt;
            let set = |body: &Body, speed: f64| moving(body.clone(), (speed * towards).to_array(), [0.0; 3]);
            scene.bodies = scene.bodies.iter().map(|body| set(body, speed(random))).collect();
        }
    }
}
