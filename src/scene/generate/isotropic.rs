//! Random sequential placement: uniform centres, isotropic rotations, a draw that overlaps an earlier body is drawn again.

use super::super::error::{FaultKind, SceneError};
use super::occupied::{Capsule, Occupied};
use crate::bodies::Bodies;
use crate::separation::Placed;
use crate::shape::Shape;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Draws of one body before placement counts as failed; at the largest accepted volume fraction the last bodies need about a hundredth.
const MAX_DRAWS: u64 = 1_000_000;
/// Stream of the first rule; streams below are those of dividing bodies, whose ids stay below 2^53.
const FIRST_STREAM: u64 = 1 << 63;

/// What is to be placed.
pub(super) struct Order {
    pub count: u64,
    pub shape: Shape,
    pub volume_fraction: f64,
    pub planar: bool,
    pub seed: u64,
    pub rule: usize,
}

/// Places the bodies, clear of those already there.
pub(super) fn add(order: &Order, bodies: &mut Bodies, group: u32) -> Result<(), SceneError> {
    let mut random = ChaCha8Rng::seed_from_u64(order.seed);
    random.set_stream(FIRST_STREAM + order.rule as u64);
    let side = side(order);
    let mut occupied = Occupied::default();
    for i in 0..bodies.len() {
        occupied.insert(Capsule::of(&bodies.shape[i], bodies.position[i], bodies.orientation[i]));
    }
    for done in 0..order.count {
        let Some((position, orientation)) = place(order, side, &occupied, &mut random) else {
            let key = format!("generate.{}.isotropic.volume_fraction", order.rule);
            let message = format!("no place for body {} of {} in {MAX_DRAWS} draws", done + 1, order.count);
            return Err(
                SceneError::new(FaultKind::Placement, key, message).with_help("a smaller volume fraction helps")
            );
        };
        occupied.insert(Capsule::of(&order.shape, position, orientation));
        bodies.push(Placed { shape: order.shape, position, orientation }, group);
    }
    Ok(())
}

fn place(order: &Order, side: f64, occupied: &Occupied, random: &mut ChaCha8Rng) -> Option<(DVec3, DQuat)> {
    (0..MAX_DRAWS).find_map(|_| {
        let mut position = side * (DVec3::from_array(random.random::<[f64; 3]>()) - 0.5);
        let orientation = rotation(random);
        if order.planar {
            position.z = 0.0;
        }
        let free = !occupied.overlaps(&Capsule::of(&order.shape, position, orientation));
        free.then_some((position, orientation))
    })
}

/// Side of the cube (in a planar scene, of the square) that the centres are in.
fn side(order: &Order) -> f64 {
    let count = order.count as f64;
    if order.planar {
        let area = PI * Capsule::body(&order.shape).1.powi(2);
        (count * area / order.volume_fraction).sqrt()
    } else {
        (count * volume(&order.shape) / order.volume_fraction).cbrt()
    }
}

/// An isotropic rotation: a uniform point of the three-sphere, from two uniform points of the disc (Marsaglia 1972).
/// It takes square roots only, which are the same on every machine.
fn rotation(random: &mut ChaCha8Rng) -> DQuat {
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

fn volume(shape: &Shape) -> f64 {
    match *shape {
        Shape::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
        Shape::Spherocylinder { diameter, length } => PI * diameter.powi(2) * (0.25 * length - diameter / 12.0),
        Shape::Ellipsoid { radii } => 4.0 / 3.0 * PI * radii.iter().product::<f64>(),
        Shape::Torus { major_radius, minor_radius } => 2.0 * PI * PI * major_radius * minor_radius.powi(2),
    }
}

/// Largest volume fraction that is accepted for a shape.
pub(in super::super) fn reachable_fraction(shape: &Shape, planar: bool) -> f64 {
    if planar {
        return 0.5;
    }
    let (half, radius) = Capsule::body(shape);
    let half = half.length();
    let aspect = 1.0 + half / radius;
    let capsule = volume(&Shape::Spherocylinder { diameter: 2.0 * radius, length: 2.0 * (half + radius) });
    capsule_fraction(aspect) * volume(shape) / capsule
}

fn capsule_fraction(aspect: f64) -> f64 {
    let _ = aspect;
    0.34
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws that the worst body and all bodies together need.
    fn draws(shape: Shape, volume_fraction: f64, count: u64, planar: bool) -> (u64, u64) {
        let order = Order { count, shape, volume_fraction, planar, seed: 1, rule: 0 };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let (side, mut occupied) = (side(&order), Occupied::default());
        let (mut worst, mut total) = (0, 0);
        for _ in 0..count {
            let mut own = 0;
            loop {
                own += 1;
                let mut position = side * (DVec3::from_array(random.random::<[f64; 3]>()) - 0.5);
                if planar {
                    position.z = 0.0;
                }
                let capsule = Capsule::of(&shape, position, rotation(&mut random));
                if !occupied.overlaps(&capsule) {
                    occupied.insert(capsule);
                    break;
                }
                if own > 300_000 {
                    return (u64::MAX, total);
                }
            }
            total += own;
            worst = worst.max(own);
        }
        (worst, total / count)
    }

    #[test]
    #[ignore = "a measurement"]
    fn measure() {
        for aspect in [1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0] {
            for fraction in [0.05, 0.1, 0.15, 0.2, 0.22, 0.24, 0.26, 0.28, 0.3, 0.32, 0.34] {
                let shape = Shape::Spherocylinder { diameter: 1.0, length: aspect };
                let result = draws(shape, fraction, 4000, false);
                println!("{aspect} {fraction} {result:?}");
                if result.0 > 100_000 {
                    break;
                }
            }
        }
        for fraction in [0.3, 0.4, 0.45, 0.48, 0.5, 0.52] {
            println!("disc {fraction} {:?}", draws(Shape::Sphere { radius: 1.0 }, fraction, 10_000, true));
        }
    }
}
