//! The exact law, written out, on problems of many spheres; and what a solver promises beside.

use super::spheres::{Step, heap};
use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Contacts of spheres of radius 1 at random in a cube, which overlap or nearly touch and move at random.
pub fn cloud(seed: u64, spheres: u32, mu: impl Fn(&mut ChaCha8Rng) -> f64, compliance: f64) -> Problem<6> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut vector = |size: f64| glam::DVec3::from_array(std::array::from_fn(|_| size * (rng.random::<f64>() - 0.5)));
    let side = 1.9 * f64::from(spheres).cbrt();
    let position: Vec<_> = (0..spheres).map(|_| vector(side)).collect();
    let mut heap = super::spheres::Spheres::new(position, vec![]);
    heap.velocity.iter_mut().for_each(|v| *v = vector(1.0));
    heap.spin.iter_mut().for_each(|w| *w = vector(1.0));
    let step = Step { dt: 0.02, friction: 0.5, gravity: glam::DVec3::ZERO, slip: 0.0, near: 0.02 };
    let mut contacts = heap.contacts(step.near);
    // Overlaps of a thousandth: spheres at random overlap by more.
    contacts.iter_mut().for_each(|contact| contact.gap = contact.gap.max(-1e-3));
    let (mut problem, _) = heap.problem(&contacts, &step);
    for (cone, k) in problem.cones.iter_mut().zip(&mut problem.compliance) {
        match cone {
            Cone::Friction(own) => *own = mu(&mut rng),
            _ => *k = compliance * rng.random::<f64>(),
        }
    }
    problem
}

/// The exact law of all contacts, to a tolerance in lengths.
pub fn check_law<const D: usize>(problem: &Problem<D>, gamma: &[f64], tolerance: f64) {
    let (g, count) = (gradient(problem, gamma), super::super::tangents::<D>());
    for (row, cone) in problem.cones.iter().enumerate() {
        let Cone::Friction(mu) = *cone else { continue };
        let scale = problem.jacobian[row].as_flattened().iter().map(|x| x * x).sum::<f64>();
        let length = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (n, t) = (gamma[row], &gamma[row + 1..=row + count]);
        let (gap, s) = (g[row], &g[row + 1..=row + count]);
        assert!(gap >= -3.0 * tolerance && n >= 0.0, "{row}: gap {gap:e}, push {n:e}");
        assert!(gap.min(scale * n) <= 3.0 * tolerance, "{row}: gap {gap:e}, push {:e}", scale * n);
        assert!(length(t) <= mu * n * (1.0 + 1e-12), "{row}: {t:?} of {mu} {n}");
        // Power of the friction: the most that the cone gives, but for a slip within the tolerance.
        let power: f64 = t.iter().zip(s).map(|(t, s)| t * s).sum();
        let lost = mu * n * length(s) + power;
        assert!(lost >= -1e-15 && scale * lost <= 9.0 * tolerance * (scale * n + length(s)), "{row}: {lost:e} {s:?}");
    }
}

#[test]
fn random_contacts_obey_the_exact_law() {
    for (seed, compliance) in [(1, 0.0), (2, 0.0), (3, 1e-3), (4, 1e-4)] {
        let problem = cloud(seed, 60, |rng| rng.random_range(0.2..1.0), compliance);
        assert!(problem.q.len() > 250, "{}", problem.q.len());
        let mut velocities = Vec::new();
        for kind in KINDS {
            let gamma = solve(kind, &problem, 1e-9);
            check_law(&problem, &gamma, 1e-9);
            velocities.push(velocity(&problem, &gamma));
        }
        for other in &velocities[1..] {
            assert!(farthest(&velocities[0], other) < 1e-6, "{seed}: {:e}", farthest(&velocities[0], other));
        }
    }
}

#[test]
fn a_falling_heap_obeys_it_and_loses_energy() {
    let gravity = glam::DVec3::new(0.0, 0.0, -9.81);
    let step = Step { dt: 0.02, friction: 0.5, gravity, slip: 1e-4, near: 0.1 };
    let mut spheres = heap(2, 3);
    let mut solver = solver(SolverKind::Auto, 1e-8);
    let (mut energy, mut most) = (f64::INFINITY, 0);
    for _ in 0..60 {
        let contacts = spheres.contacts(step.near);
        let (problem, mut gamma) = spheres.problem(&contacts, &step);
        let outcome = solver.solve(&problem, &mut gamma);
        assert_eq!(outcome.status, Status::Solved, "{outcome:?}");
        check_law(&problem, &gamma, 1e-8);
        spheres.accept(&contacts, &problem, &gamma, &step);
        assert!(spheres.energy(&step) <= energy + 1e-3, "{} {energy}", spheres.energy(&step));
        energy = spheres.energy(&step);
        most = most.max(contacts.len());
    }
    assert!(most > 15, "{most}");
}

#[test]
fn without_friction_the_tangents_count_nothing() {
    let with = cloud(5, 40, |_| 0.0, 1e-3);
    let normal: Vec<usize> = (0..with.q.len()).filter(|row| with.cones[*row] != Cone::Tangent).collect();
    let without = Problem::<6> {
        bodies: with.bodies,
        pair: normal.iter().map(|row| with.pair[*row]).collect(),
        jacobian: normal.iter().map(|row| with.jacobian[*row]).collect(),
        q: normal.iter().map(|row| with.q[*row]).collect(),
        ..Problem::default()
    };
    let alone = Problem { cones: vec![Cone::Ray; normal.len()], ..without.clone() };
    let expected = velocity(&without, &solve(SolverKind::PairBlockCg, &without, 1e-11));
    for kind in KINDS {
        let gamma = solve(kind, &with, 1e-11);
        assert!(with.cones.iter().zip(&gamma).all(|(cone, gamma)| *cone != Cone::Tangent || *gamma == 0.0));
        assert!(farthest(&expected, &velocity(&with, &gamma)) < 1e-9);
        assert!(farthest(&expected, &velocity(&alone, &solve(kind, &alone, 1e-11))) < 1e-9);
    }
}

#[test]
fn a_start_at_the_solution_takes_few_iterations_and_the_same_bits_come_twice() {
    let problem = cloud(6, 60, |_| 0.6, 1e-3);
    for kind in KINDS {
        let gamma = solve(kind, &problem, 1e-9);
        assert_eq!(gamma, solve(kind, &problem, 1e-9));
        let mut again = gamma.clone();
        let outcome = solver(kind, 1e-7).solve(&problem, &mut again);

        assert!(outcome.status == Status::Solved && outcome.iterations <= 3, "{kind:?}: {outcome:?}");
        // A tighter solve goes on where the last one ended.
        let mut going = solver(kind, 1e-5);
        let mut gamma = Vec::new();
        let first = going.solve(&problem, &mut gamma);
        going.set_settings(Settings { tolerance: 1e-9, max_iterations: 20_000 });
        let second = going.resume(&mut gamma);
        assert_eq!((first.status, second.status), (Status::Solved, Status::Solved), "{kind:?}");
        check_law(&problem, &gamma, 1e-9);
    }
}

#[test]
fn starts_that_are_no_multipliers_do_no_harm() {
    let problem = cloud(7, 20, |_| 0.4, 1e-3);
    let expected = velocity(&problem, &solve(SolverKind::Auto, &problem, 1e-10));
    let mut gamma = vec![-1.0; problem.q.len()];
    (gamma[3], gamma[4], gamma[6]) = (f64::NAN, 1e3, f64::INFINITY);
    let outcome = solver(SolverKind::Auto, 1e-10).solve(&problem, &mut gamma);
    assert_eq!(outcome.status, Status::Solved);
    assert!(farthest(&expected, &velocity(&problem, &gamma)) < 1e-7);
    let mut broken = problem.clone();
    broken.q[5] = f64::NAN;
    let outcome: Outcome = solver(SolverKind::Auto, 1e-10).solve(&broken, &mut vec![]);
    assert_eq!(outcome.status, Status::NotFinite);
    let limit = Settings { tolerance: 1e-10, max_iterations: 2 };
    let outcome = Solver::new(SolverKind::Auto, limit).solve(&problem, &mut vec![]);
    assert_eq!((outcome.status, outcome.iterations), (Status::MaxIterations, 2));
}

#[test]
fn a_problem_without_rows_is_solved() {
    let mut gamma = vec![1.0; 3];
    let problem = Problem::<6> { bodies: 3, ..Problem::default() };
    assert_eq!(solver(SolverKind::Auto, 1e-9).solve(&problem, &mut gamma).status, Status::Solved);
    assert!(gamma.is_empty());
}

#[test]
fn solvers_without_cones_refuse() {
    let problem = cloud(8, 10, |_| 0.4, 0.0);
    for (_, kind) in SolverKind::NAMED.into_iter().filter(|(_, kind)| !kind.supports_friction()) {
        let problem = problem.clone();
        let refused = std::panic::catch_unwind(move || solver(kind, 1e-6).solve(&problem, &mut vec![]));
        assert!(refused.is_err(), "{kind:?}");
    }
    assert!(KINDS.iter().all(|kind| kind.supports_friction()));
}

#[test]
fn a_wide_cone_hides_no_overlap() {
    // With a coefficient of 10 the projection of an overlap on the cone is a tenth of it.
    let block = |row: usize, side: usize| std::array::from_fn(|k| if k == row { side as f64 - 0.5 } else { 0.0 });
    let problem = Problem::<6> {
        bodies: 2,
        pair: vec![[0, 1]; 3],
        jacobian: (0..3).map(|row| std::array::from_fn(|side| block(row, side))).collect(),
        q: vec![-1e-3, 0.5, 0.0],
        cones: vec![Cone::Friction(10.0), Cone::Tangent, Cone::Tangent],
        compliance: vec![0.0; 3],
    };
    let settings = Settings { tolerance: 1e-9, max_iterations: 0 };
    let outcome = Solver::new(SolverKind::Auto, settings).solve(&problem, &mut vec![0.0; 3]);
    assert!(outcome.residual >= 1e-3, "{outcome:?}");
}

#[test]
fn held_corrections_leave_gaps_and_no_overlap() {
    for (seed, mu) in [(1, 1.0), (2, 2.0), (3, 5.0)] {
        let problem = cloud(seed, 60, |_| mu, 1e-4);
        // Too few iterations for the exact law.
        let settings = Settings { tolerance: 1e-8, max_iterations: 8 };
        let mut solver = Solver::new(SolverKind::Auto, settings);
        let mut gamma = vec![0.0; problem.q.len()];
        let exact = solver.solve(&problem, &mut gamma);
        assert_ne!(exact.status, Status::Solved, "{exact:?}");
        solver.set_settings(Settings { max_iterations: 100_000, ..settings });
        let held = solver.relax(&problem, &mut gamma, 1e-6);
        assert_eq!(held.status, Status::HeldFriction, "{held:?}");
        let g = gradient(&problem, &gamma);
        for row in (0..g.len()).filter(|row| problem.cones[*row] != Cone::Tangent) {
            assert!(g[row] >= -1e-6, "{row}: {}", g[row]);
            let friction = gamma[row + 1].hypot(gamma[row + 2]);
            assert!(friction <= mu * gamma[row] * (1.0 + 1e-12));
        }
    }
}
