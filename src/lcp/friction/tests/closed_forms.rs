//! One step of a sphere on a plane, against what mechanics says.

use super::*;

/// The planar problem of a disc of radius 1 that touches a fixed line below it: tangent `x`, normal `y`. `mobility` of
/// its move and turn (zero: it does not turn), `free` the displacements and the turn of the step without contact.
fn disc(mobility: [f64; 2], free: [f64; 3], mu: f64) -> Problem<3> {
    let roots = [mobility[0].sqrt(), mobility[0].sqrt(), mobility[1].sqrt()];
    // The point below the centre moves by `x + turn` (a turn about z, counter-clockwise) and `y`.
    let rows = [[0.0, 1.0, 0.0], [1.0, 0.0, 1.0]];
    Problem {
        bodies: 2,
        pair: vec![[1, 0]; 2],
        jacobian: rows.iter().map(|row| [[0.0; 3], std::array::from_fn(|k| roots[k] * row[k])]).collect(),
        q: rows.iter().map(|row| (0..3).map(|k| row[k] * free[k]).sum()).collect(),
        cones: vec![Cone::Friction(mu), Cone::Tangent],
        compliance: vec![],
    }
}

/// What the disc moves and turns by.
fn moved(mobility: [f64; 2], free: [f64; 3], mu: f64) -> [f64; 3] {
    let problem = disc(mobility, free, mu);
    let of = |kind| {
        let gamma = solve(kind, &problem, 1e-12);
        let v = velocity(&problem, &gamma)[0];
        let roots = [mobility[0].sqrt(), mobility[0].sqrt(), mobility[1].sqrt()];
        std::array::from_fn(|k| free[k] + roots[k] * v[k])
    };
    let all: [[f64; 3]; 3] = KINDS.map(of);
    for other in &all[1..] {
        (0..3).for_each(|k| assert!((other[k] - all[0][k]).abs() < 1e-11, "{all:?}"));
    }
    all[0]
}

#[test]
fn a_body_on_an_incline_slides_or_sticks() {
    // Speeds after a second of steps of 0.01, each the same: of a body that does not turn.
    let dt = 0.01;
    let speed = |angle: f64, mu: f64| {
        let along = 9.81 * angle.sin() * dt * dt;
        let [x, y, _] = moved([1.0, 0.0], [along, -9.81 * angle.cos() * dt * dt, 0.0], mu);
        assert!(y.abs() < 1e-12, "{y:e}");
        x / dt / dt
    };
    assert!((speed(0.4, 0.3) - 1.109511).abs() < 1e-6);
    assert!(speed(0.4, 0.5).abs() < 1e-7);
    let limit = 0.5_f64.atan();
    assert!(speed(limit - 1e-3, 0.5).abs() < 1e-7);
    assert!((speed(limit + 1e-3, 0.5) - 0.0109679).abs() < 1e-7);
}

#[test]
fn a_sphere_on_an_incline_rolls_or_slides() {
    let run = |mu: f64| {
        let (s, c) = 0.5_f64.sin_cos();
        let [x, y, turn] = moved([1.0, 2.5], [9.81 * s, -9.81 * c, 0.0], mu);
        assert!(y.abs() < 1e-11);
        (x, -turn)
    };
    let (speed, spin) = run(0.3);
    assert!((speed - 3.359403).abs() < 1e-6 && (spin - speed).abs() < 1e-11, "{speed} {spin}");
    let (speed, spin) = run(0.1);
    assert!((speed - 3.842256).abs() < 1e-6 && (spin - 2.152271).abs() < 1e-6, "{speed} {spin}");
}

#[test]
fn pushes_without_inertia_slide_stick_and_roll() {
    // Force 1 along the wall and `press` against it, mobility 1/2 and of turning 3/2.
    let push = |turning: f64, press: f64, mu: f64| moved([0.5, turning], [0.5, -0.5 * press, 0.0], mu);
    assert!((push(0.0, 1.0, 0.3)[0] - 0.35).abs() < 1e-11);
    assert!(push(0.0, 1.0, 2.0)[0].abs() < 1e-11);
    let [x, _, turn] = push(1.5, 1.0, 0.3);
    assert!((x - 0.375).abs() < 1e-11 && (turn + 0.375).abs() < 1e-11, "{x} {turn}");
    let [x, _, turn] = push(1.5, 0.2, 0.3);
    assert!((x - 0.47).abs() < 1e-11 && (turn + 0.09).abs() < 1e-11, "{x} {turn}");
}

#[test]
fn friction_is_against_the_slip_in_every_direction() {
    for turn in 0..19 {
        let angle = f64::from(turn) * 0.33;
        let (s, c) = angle.sin_cos();
        let unit = |k: usize| std::array::from_fn(|i| f64::from(u8::from(i == k)));
        let problem = Problem::<6> {
            bodies: 2,
            pair: vec![[1, 0]; 3],
            jacobian: [2, 0, 1].map(|k| [[0.0; 6], unit(k)]).to_vec(),
            q: vec![-0.1, 3.0 * c, 3.0 * s],
            cones: vec![Cone::Friction(0.4), Cone::Tangent, Cone::Tangent],
            compliance: vec![],
        };
        for kind in KINDS {
            let gamma = solve(kind, &problem, 1e-12);
            assert!((gamma[0] - 0.1).abs() < 1e-11, "{gamma:?}");
            assert!((gamma[1] + 0.04 * c).abs() < 1e-11 && (gamma[2] + 0.04 * s).abs() < 1e-11, "{gamma:?}");
        }
    }
}

#[test]
fn an_elastic_slip_takes_its_part() {
    // A pull of 0.02 against a slip of `k gamma_t`: `A` is 1, so the force is 0.02 / (1 + k), unless that is too much.
    let mut problem = disc([1.0, 0.0], [0.02, -0.1, 0.0], 0.5);
    problem.compliance = vec![0.0, 3.0];
    for kind in KINDS {
        let gamma = solve(kind, &problem, 1e-12);
        assert!((gamma[0] - 0.1).abs() < 1e-11 && (gamma[1] + 0.005).abs() < 1e-11, "{gamma:?}");
    }
    problem.q[1] = 0.5;
    for kind in KINDS {
        let gamma = solve(kind, &problem, 1e-12);
        assert!((gamma[0] - 0.1).abs() < 1e-11 && (gamma[1] + 0.05).abs() < 1e-11, "{gamma:?}");
    }
}
