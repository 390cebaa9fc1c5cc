//! Two balls on rigid bonds under gravity, against the equations of the double pendulum by the method of Runge and
//! Kutta (L. D. Landau, E. M. Lifshitz, *Mechanics*, section 5, problem 1, has the Lagrangian).

use crate::implicit_bonds::inertial;
use crate::scenes::watch;
use glam::DVec3;
use serde_json::{Value, json};

const GRAVITY: f64 = 10.0;
const START: [f64; 2] = [1.0, 1.6];
const END: f64 = 1.2;

/// The place of a ball on a bond of length 1 at an angle from the vertical.
fn end_of_bond(angle: f64) -> DVec3 {
    DVec3::new(angle.sin(), 0.0, -angle.cos())
}

fn double_pendulum(dt: f64) -> Value {
    let first = end_of_bond(START[0]);
    let ball = |at: DVec3| json!({"shape": {"sphere": {"radius": 0.1}}, "position": at.to_array()});
    let mut anchor = ball(DVec3::ZERO);
    anchor["fixed"] = json!(true);
    let bond =
        |bodies: [usize; 2]| json!({"bodies": bodies, "at": [[0, 0, 0], [0, 0, 0]], "stiffness": "rigid", "length": 1});
    json!({"name": "double-pendulum", "time": {"dt": dt, "end": END}, "dynamics": inertial(),
        "contact": {"overlap_tolerance": 1e-8}, "solver": {"tolerance": 1e-10},
        "forces": [{"gravity": {"acceleration": [0, 0, -GRAVITY]}}],
        "bodies": [anchor, ball(first), ball(first + end_of_bond(START[1]))], "bonds": [bond([0, 1]), bond([1, 2])]})
}

/// The rates of both angles and of their rates, for equal masses and lengths of 1.
fn rates([a, b, va, vb]: [f64; 4]) -> [f64; 4] {
    let (sine, cosine) = (a - b).sin_cos();
    let mass = 3.0 - (2.0 * (a - b)).cos();
    let first = -3.0 * GRAVITY * a.sin() - GRAVITY * (a - 2.0 * b).sin() - 2.0 * sine * (vb * vb + va * va * cosine);
    let second = 2.0 * sine * (2.0 * va * va + 2.0 * GRAVITY * a.cos() + vb * vb * cosine);
    [va, vb, first / mass, second / mass]
}

/// The angles at the end, with an error far below that of any step here.
fn expected() -> [f64; 2] {
    const STEPS: u32 = 20_000;
    let h = END / f64::from(STEPS);
    let mut state = [START[0], START[1], 0.0, 0.0];
    let along = |state: [f64; 4], rate: [f64; 4], h: f64| std::array::from_fn(|i| state[i] + h * rate[i]);
    for _ in 0..STEPS {
        let one = rates(state);
        let two = rates(along(state, one, 0.5 * h));
        let three = rates(along(state, two, 0.5 * h));
        let four = rates(along(state, three, h));
        state = std::array::from_fn(|i| state[i] + h / 6.0 * (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i]));
    }
    [state[0], state[1]]
}

/// Both balls at the end of a run.
fn balls(dt: f64) -> [DVec3; 2] {
    let mut last = [DVec3::ZERO; 2];
    watch(&double_pendulum(dt), |bodies| last = [bodies.position[1], bodies.position[2]]);
    last
}

#[test]
fn a_double_pendulum_follows_its_equations_to_first_order_in_dt() {
    let [a, b] = expected();
    let right = [end_of_bond(a), end_of_bond(a) + end_of_bond(b)];
    let off = |balls: [DVec3; 2]| balls[0].distance(right[0]).max(balls[1].distance(right[1]));
    let [coarse, fine, finest] = [4e-3, 2e-3, 1e-3].map(balls);
    let [far, near, nearest] = [coarse, fine, finest].map(off);
    // The term of first order taken out.
    let extrapolated = off([0, 1].map(|i| 2.0 * finest[i] - fine[i]));
    println!("errors {far:.2e}, {near:.2e}, {nearest:.2e}; extrapolated {extrapolated:.1e}; angles {a:.4}, {b:.4}");
    assert!((far / near - 2.0).abs() < 0.1 && (near / nearest - 2.0).abs() < 0.05, "{far} {near} {nearest}");
    assert!(extrapolated < 0.05 * nearest, "{extrapolated}");
}
