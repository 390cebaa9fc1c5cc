//! Every row of a body with a wall is the derivative of its gap along `C(U)`, at the step's start and at a trial.

use crate::random::Random;
use relcp::internals::constraint::{self, FIXED, Mover};
use relcp::internals::dynamics::{Ending, Factor, Motion, Pose, Root, Twist, advance};
use relcp::internals::freedom::SPATIAL;
use relcp::internals::separation::Surface;
use relcp::lcp::Problem;
use relcp::separation::{Placed, Separation};
use relcp::shape::Shape;

const KINDS: [&str; 4] = ["sphere", "spherocylinder", "ellipsoid", "torus"];

const POSES_A_KIND: usize = 40;
/// Step of the fourth-order difference in units of the displacement `dt U`.
const STEP: f64 = 5e-4;

fn moved(placed: &Placed, twist: Twist, dt: f64) -> Placed {
    let pose = advance(Pose { position: placed.position, orientation: placed.orientation }, twist, dt);
    Placed { shape: placed.shape, position: pose.position, orientation: pose.orientation }
}

fn nudged(twist: Twist, axis: usize, by: f64) -> Twist {
    let mut nudged = twist;
    if axis < 3 {
        nudged.linear[axis] += by
    } else {
        nudged.angular[axis - 3] += by
    }
    nudged
}

fn gap(surface: &Surface, placed: &Placed, place: u32) -> Option<Separation> {
    let mut at = None;
    surface.places(placed, |k, found| at = at.or((k == place).then_some(found)));
    at
}

/// The gap at `to` of the place that a body at `from` touches in: of a ring's places beside the farthest that of the
/// same part of its tube.
fn gap_of_place(surface: &Surface, from: &Placed, to: &Placed, place: u32) -> Option<Separation> {
    let (Shape::Torus { minor_radius, .. }, 1..) = (from.shape, place) else { return gap(surface, to, place) };
    let found = gap(surface, from, place)?;
    let arm = from.orientation.inverse() * (found.lever_a - minor_radius * found.normal);
    let part =
        Placed { shape: Shape::Sphere { radius: minor_radius }, position: to.position + to.orientation * arm, ..*to };
    gap(surface, &part, 0)
}

/// Each place's row is the derivative of its gap along `C(U)`, at a start and at a trial, and the wall's block is zero.
#[test]
fn rows_of_walls_equal_finite_differences() {
    let mut random = Random::new(3);
    let motion = Motion {
        free: Twist::default(),
        factor: Factor { translation: Root::Even(1.0), rotation: glam::DMat3::IDENTITY },
        ending: Ending::default(),
    };
    for kind in KINDS {
        for which in 0..3 {
            let (mut checked, mut worst) = (0, 0.0_f64);
            while checked < POSES_A_KIND {
                let dt = 10f64.powf(random.within(-3.0, 0.0));
                let placed =
                    Placed { shape: random.shape(kind), position: random.vector(), orientation: random.orientation() };
                let surface = match which {
                    0 => Surface::Plane { point: random.vector(), normal: random.direction() },
                    1 => Surface::Sphere { centre: random.vector(), radius: random.within(1.0, 4.0) },
                    _ => Surface::Cylinder {
                        centre: random.vector(),
                        axis: random.direction(),
                        radius: random.within(1.0, 4.0),
                    },
                };
                let trial = Twist { linear: random.vector() * 0.05 / dt, angular: random.vector() * 0.3 / dt };
                let at = if checked % 2 == 0 { Twist::default() } else { trial };
                for place in 0..3 {
                    let Some(found) = gap(&surface, &moved(&placed, at, dt), place) else { continue };
                    let mut problem = Problem::<SPATIAL> { bodies: 2, ..Problem::default() };
                    let mover = Mover { motion: &motion, reached_with: at, axis: None };
                    constraint::append(&mut problem, [0, 1], constraint::row(&found, [mover, FIXED], dt));
                    assert!(problem.jacobian[0][1].iter().all(|x| *x == 0.0));
                    let derivative = problem.jacobian[0][0].map(|x| x * dt.sqrt());
                    let mut expected = [0.0; 6];
                    let mut jumps = false;
                    for (axis, expected) in expected.iter_mut().enumerate() {
                        let here = moved(&placed, at, dt);
                        let phi = |k: f64| {
                            let to = moved(&placed, nudged(at, axis, k * STEP / dt), dt);
                            gap_of_place(&surface, &here, &to, place).unwrap()
                        };
                        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(phi);
                        // Near where another point becomes the farthest.
                        jumps |= a.lever_a.distance(d.lever_a) > 0.1;
                        *expected =
                            (8.0 * (c.separation - b.separation) - (d.separation - a.separation)) / (12.0 * STEP / dt);
                    }
                    if jumps {
                        continue;
                    }
                    let scale = dt * expected.iter().fold(1.0_f64, |m, x| m.max((x / dt).abs()));
                    for (row, expected) in derivative.iter().zip(expected) {
                        worst = worst.max((row - expected).abs() / scale);
                    }
                    let u = [at.linear.to_array(), at.angular.to_array()].concat();
                    let back: f64 = derivative.iter().zip(u).map(|(d, u)| d * u).sum();
                    assert!((problem.q[0] - (found.separation - back)).abs() < 1e-12);
                    checked += 1;
                }
            }
            println!("{kind} {which}: worst {worst:.1e}");
            assert!(worst < 1e-6, "{kind} {which}: {worst:e}");
        }
    }
}
