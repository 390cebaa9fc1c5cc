//! Every row is the derivative of the separation along `C(U)`, at the step's start and at a trial, for every pair of
//! shapes.

use crate::random::{KINDS, Random};
use glam::{DMat3, DVec3};
use relcp::internals::constraint::{self, Mover};
use relcp::internals::dynamics::{Ending, Factor, Motion, Pose, Root, Twist, advance};
use relcp::internals::freedom::SPATIAL;
use relcp::lcp::Problem;
use relcp::separation::{Placed, separation};

const PAIRS_A_KIND: usize = 40;
/// Step of the fourth-order difference in units of the displacement `dt U`: its error is about `step^4` of the fifth
/// derivative.
const STEP: f64 = 5e-4;

fn unit_motion() -> Motion {
    Motion {
        free: Twist::default(),
        factor: Factor { translation: Root::Even(1.0), rotation: DMat3::IDENTITY },
        ending: Ending::default(),
    }
}

fn moved(placed: &Placed, twist: Twist, dt: f64) -> Placed {
    let pose = advance(Pose { position: placed.position, orientation: placed.orientation }, twist, dt);
    Placed { shape: placed.shape, position: pose.position, orientation: pose.orientation }
}

fn nudged(twist: Twist, axis: usize, by: f64) -> Twist {
    let mut packed = [0.0; 6];
    packed[axis] = by;
    Twist {
        linear: twist.linear + DVec3::new(packed[0], packed[1], packed[2]),
        angular: twist.angular + DVec3::new(packed[3], packed[4], packed[5]),
    }
}

/// The row's derivative with respect to both bodies' velocities, from `J = sqrt(dt) D` at unit mobility, and the row's
/// constant part `q = Phi - dt D . U_j` at zero free velocity.
fn row(a: &Placed, b: &Placed, at: [Twist; 2], dt: f64) -> ([[f64; 6]; 2], f64, f64) {
    let found = separation(&moved(a, at[0], dt), &moved(b, at[1], dt), None).unwrap();
    let motion = unit_motion();
    let movers = at.map(|reached_with| Mover { motion: &motion, reached_with, axis: None });
    let mut problem = Problem::<SPATIAL>::default();
    constraint::append(&mut problem, [0, 1], constraint::row(&found, movers, dt));
    let derivative = problem.jacobian[0].map(|block| block.map(|x| x * dt.sqrt()));
    (derivative, problem.q[0], found.separation)
}

/// `d Phi(C(U)) / dU` by central differences, or none where the normal jumps (a ring's nearest point changes side).
fn difference(a: &Placed, b: &Placed, at: [Twist; 2], dt: f64) -> Option<[[f64; 6]; 2]> {
    let mut out = [[0.0; 6]; 2];
    for (body, axis) in (0..2).flat_map(|body| (0..6).map(move |axis| (body, axis))) {
        let phi = |k: f64| {
            let mut twist = at;
            twist[body] = nudged(at[body], axis, k * STEP / dt);
            separation(&moved(a, twist[0], dt), &moved(b, twist[1], dt), None).unwrap()
        };
        let [far_low, low, high, far_high] = [-2.0, -1.0, 1.0, 2.0].map(phi);
        if far_low.normal.dot(far_high.normal) < 1.0 - 1e-3 {
            return None;
        }
        let slope = 8.0 * (high.separation - low.separation) - (far_high.separation - far_low.separation);
        out[body][axis] = slope / (12.0 * STEP / dt);
    }
    Some(out)
}

fn check(first: bool) {
    let mut random = Random::new(7);
    for kinds in KINDS {
        let (mut checked, mut worst) = (0, 0.0f64);
        while checked < PAIRS_A_KIND {
            let dt = 10f64.powf(random.within(-3.0, 0.0));
            let (a, b, _) = random.pair(kinds);
            let mut velocity = || Twist { linear: random.vector() * 0.05 / dt, angular: random.vector() * 0.3 / dt };
            let at = if first { [Twist::default(); 2] } else { [velocity(), velocity()] };
            let (derivative, q, phi) = row(&a, &b, at, dt);
            // Separations of interest: a body's surface near or a little inside another's.
            if phi.abs() > 0.3 {
                continue;
            }
            let Some(expected) = difference(&a, &b, at, dt) else { continue };
            let scale = dt * expected.as_flattened().iter().fold(1.0f64, |m, x| m.max((x / dt).abs()));
            for (found, expected) in derivative.as_flattened().iter().zip(expected.as_flattened()) {
                worst = worst.max((found - expected).abs() / scale);
            }
            let back: f64 = [0, 1]
                .iter()
                .map(|&i| {
                    let t = at[i];
                    let u = [t.linear.x, t.linear.y, t.linear.z, t.angular.x, t.angular.y, t.angular.z];
                    derivative[i].iter().zip(u).map(|(d, u)| d * u).sum::<f64>()
                })
                .sum();
            assert!((q - (phi - back)).abs() < 1e-12, "{kinds:?}: the row's constant part {q}, {phi} - {back}");
            checked += 1;
        }
        println!("{kinds:?} {}: worst {worst:.1e}", if first { "first" } else { "appended" });
        assert!(worst < 1e-6, "{kinds:?}: a row differs from the finite difference by {worst:e}");
    }
}

#[test]
fn first_rows_equal_finite_differences() {
    check(true);
}

#[test]
fn appended_rows_equal_finite_differences() {
    check(false);
}

#[test]
fn the_plain_arm_would_fail_at_a_trial() {
    let (lever, normal) = (DVec3::new(0.3, 0.1, -0.7), DVec3::new(0.6, 0.0, 0.8));
    let exact = constraint::torque_arm(lever, normal, DVec3::new(0.2, -0.4, 0.3), 1.0);
    assert!((exact - lever.cross(normal)).length() > 1e-2);
    assert_eq!(constraint::torque_arm(lever, normal, DVec3::ZERO, 1.0), lever.cross(normal));
}
