//! How long steps may be in a trap: what a step makes of a free body's distance from the centre must not grow.
//!
//! A step is linear in the distance `x`, and with inertia in the velocity: `(x, dt u)' = M (x, dt u)`. It is stable
//! where no eigenvalue of `M` is beyond the unit circle, which is where `|tr M| <= 1 + det M` and `det M <= 1` (E. I.
//! Jury,
//! *Theory and Application of the z-Transform Method*, 1964, section 3.5). Overdamped steps, of Euler and by the
//! midpoint, end at `k dt / (xi L) = 2`, those of inertia without drag at `dt sqrt(k / m) = 2`.

use super::{Dynamics, damping::rates};
use crate::shape::Shape;
use glam::DVec3;

/// Rounding of the criterion, so that steps that keep an oscillation as it is are stable.
const ROUNDING: f64 = 1e-9;

/// Halvings of the length of a step, and of the interval that its limit is in: to rounding.
const HALVINGS: u32 = 60;

/// The longest stable step of a body in a trap of this stiffness, where `dt` is too long; else none. `midpoint` is the
/// stepping.
pub fn longest_stable_step(dynamics: &Dynamics, midpoint: bool, shape: &Shape, stiffness: f64, dt: f64) -> Option<f64> {
    let stable = |dt: f64| match *dynamics {
        Dynamics::Overdamped { drag } => {
            stiffness * dt <= 2.0 * (1.0 + ROUNDING) * drag.resistance(shape).linear.least()
        }
        _ => {
            let density = dynamics.density().unwrap_or(1.0);
            let drag = dynamics.drag_beside_inertia();
            let rates = drag.map_or(DVec3::ZERO, |drag| rates(drag, density, shape).0.axes());
            // Of a body that may turn, along its axis of least drag as along that of most.
            let mass = density * shape.volume();
            let of = |rate: f64| is_stable_with_inertia(midpoint, mass, rate, stiffness, dt);
            of(rates.min_element()) && of(rates.max_element())
        }
    };
    if stable(dt) {
        return None;
    }
    let mut short = dt;
    for _ in 0..HALVINGS {
        if stable(short) {
            break;
        }
        short *= 0.5;
    }
    let mut long = 2.0 * short;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (short + long);
        *(if stable(middle) { &mut short } else { &mut long }) = middle;
    }
    Some(short)
}

fn is_stable_with_inertia(midpoint: bool, mass: f64, rate: f64, stiffness: f64, dt: f64) -> bool {
    let a = dt * rate;
    // The squared frequency over that of the steps.
    let s = dt * dt * stiffness / mass;
    let share = |a: f64| if a > 0.0 { -(-a).exp_m1() / a } else { 1.0 };
    let [[xx, xu], [ux, uu]] = if midpoint {
        // Half of the drag and of the force before the move and half after it, the force that of the middle.
        let (kept, push) = ((-0.5 * a).exp(), 0.5 * s * share(0.5 * a));
        let middle = [1.0 - 0.5 * push, 0.5 * kept];
        let late = (1.0 + kept) * push;
        [[1.0 - push * middle[0], kept - push * middle[1]], [-late * middle[0], kept * kept - late * middle[1]]]
    } else {
        let (kept, push) = ((-a).exp(), s * share(a));
        [[1.0 - push, kept], [-push, kept]]
    };
    let (trace, determinant) = (xx + uu, xx * uu - xu * ux);
    trace.abs() <= 1.0 + determinant + ROUNDING && determinant <= 1.0 + ROUNDING
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_that_are_known() {
        let ball = Shape::Sphere { radius: 0.5 };
        let limit = |dynamics: Dynamics, midpoint| longest_stable_step(&dynamics, midpoint, &ball, 3.0, 1e4).unwrap();
        for midpoint in [false, true] {
            // 2 xi L / k; 2 sqrt(m / k).
            let overdamped = limit(Dynamics::Overdamped { drag: 1.5.into() }, midpoint);
            assert!((overdamped - 1.0).abs() < 1e-8, "{overdamped}");
            let inertial = limit(Dynamics::Inertial { density: 2.0, drag: None }, midpoint);
            let expected = 2.0 * (2.0 * ball.volume() / 3.0).sqrt();
            assert!((inertial - expected).abs() < 1e-6, "{inertial} {expected}");
            // Strong drag is the overdamped law in steps of first order.
            let damped = limit(Dynamics::Inertial { density: 1e-6, drag: Some(1.5.into()) }, midpoint);
            assert!(if midpoint { damped < 2.0 } else { (damped - 1.0).abs() < 1e-4 }, "{damped}");
            assert_eq!(
                longest_stable_step(&Dynamics::Overdamped { drag: 1.5.into() }, midpoint, &ball, 3.0, 1.0),
                None
            );
        }
    }
}
