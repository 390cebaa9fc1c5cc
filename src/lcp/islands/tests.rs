use super::groups::gather;
use super::*;
use crate::lcp::product::dot;
use crate::lcp::{Solver, SolverKind, velocity};

const SETTINGS: Settings = Settings { tolerance: 1e-7, max_iterations: 100_000 };

/// Rows of spheres in chains, of which each has a body on a wall; nearer the more the later the chain.
fn chains(links: &[u32]) -> Problem<3> {
    let wall = links.iter().map(|links| links + 1).sum::<u32>();
    let mut problem = Problem { bodies: wall as usize + 1, ..Problem::default() };
    let mut first = 0;
    for (chain, links) in (1..).zip(links) {
        let mut add = |pair: [u32; 2], jacobian: [[f64; 3]; 2]| {
            let place = problem.pair.len() as f64;
            problem.pair.push(pair);
            problem.jacobian.push(jacobian);
            problem.q.push(-f64::from(chain) * (1.5 + (7.0 * place).sin()));
        };
        let along = |x: f64| [x, 0.1 * x, 0.0];
        (first..first + links).for_each(|body| add([body, body + 1], [along(-1.0), along(1.0)]));
        add([first, wall], [along(1.0), [0.0; 3]]);
        first += links + 1;
    }
    problem
}

/// A solver that knows the order of bodies, as in a step.
fn solver(bodies: usize) -> Solver<3> {
    let mut solver = Solver::new(SolverKind::Auto, SETTINGS);
    let place = (0..bodies as u32).rev().collect();
    solver.place(Places { place, blocks: vec![0, bodies as u32 / 2, bodies as u32] }, Alone);
    solver
}

/// `max |min(g, s gamma)|` by the definition.
fn residual(problem: &Problem<3>, gamma: &[f64]) -> f64 {
    residual_from(problem, gamma, 0)
}

/// That of the rows from this one on.
fn residual_from(problem: &Problem<3>, gamma: &[f64], first: usize) -> f64 {
    let v = velocity(problem, gamma);
    let of_row = |(row, gamma): (usize, &f64)| {
        let own: f64 = problem.jacobian[row].iter().map(|block| dot(block, block)).sum();
        problem.value(row, &v).min(own * gamma).abs()
    };
    gamma.iter().enumerate().skip(first).map(of_row).fold(0.0, f64::max)
}

#[test]
fn islands_are_solved_as_the_whole_is() {
    let problem = chains(&[150, 3, 400, 2, 140, 90, 60]);
    let mut by_islands = solver(problem.bodies);
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    let outcome = by_islands.solve(&problem, &mut ours);
    assert!(by_islands.islands.are_used() && by_islands.islands.islands.len() == 5);
    let whole = Solver::new(SolverKind::Auto, SETTINGS).solve(&problem, &mut theirs);
    assert_eq!([outcome.status, whole.status], [Status::Solved; 2]);
    assert!(residual(&problem, &ours) <= 1.001 * SETTINGS.tolerance && outcome.residual <= SETTINGS.tolerance);
    let (v, w) = (velocity(&problem, &ours), velocity(&problem, &theirs));
    let apart = v.as_flattened().iter().zip(w.as_flattened()).map(|(v, w)| (v - w).abs()).fold(0.0, f64::max);
    let size = v.as_flattened().iter().fold(0.0, |size: f64, v| size.max(v.abs()));
    assert!(apart < 1e-4 * size, "{apart:e} of {size:e}");
}

#[test]
fn an_island_is_solved_alike_beside_any_others_and_on_any_number_of_threads() {
    let (problem, more) = (chains(&[150, 400]), chains(&[150, 400, 1_600, 130]));
    let solved = |problem: &Problem<3>| {
        let mut gamma = Vec::new();
        let outcome = solver(problem.bodies).solve(problem, &mut gamma);
        assert_eq!(outcome.status, Status::Solved);
        gamma
    };
    let ours = solved(&problem);
    let beside = solved(&more);
    assert_eq!(ours[..], beside[..ours.len()]);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| solved(&more)), beside, "{threads} threads");
    }
}

#[test]
fn an_island_without_new_rows_is_not_solved_again() {
    let mut problem = chains(&[150, 200, 300]);
    let mut solver = solver(problem.bodies);
    let mut gamma = Vec::new();
    solver.solve(&problem, &mut gamma);
    let before = gamma.clone();
    let again = solver.solve_next(&problem, &mut gamma);
    assert_eq!((again.iterations, again.products, &gamma), (0, 0, &before));
    // One more row of the second chain, against its first.
    let first = 151;
    problem.pair.push(problem.pair[first]);
    problem.jacobian.push(problem.jacobian[first]);
    problem.q.push(problem.q[first] - 1.0);
    let next = solver.solve_next(&problem, &mut gamma);
    assert!(next.status == Status::Solved && residual(&problem, &gamma) <= 1.001 * SETTINGS.tolerance);
    let own = 151..352;
    let same = |row: &usize| own.contains(row) || gamma[*row] == before[*row];
    assert!((0..before.len()).all(|row| same(&row)) && gamma[own.clone()] != before[own]);
    // A tighter solve goes on with all of them.
    solver.set_settings(Settings { tolerance: 1e-9, ..SETTINGS });
    let tighter = solver.resume(&mut gamma);
    assert!(tighter.status == Status::Solved && residual(&problem, &gamma) <= 1.1e-9, "{tighter:?}");
    // Multipliers that others have changed are solved again.
    gamma[0] += 1.0;
    assert!(solver.solve_next(&problem, &mut gamma).iterations > 0);
    assert!(residual(&problem, &gamma) <= 1.1e-9);
}

#[test]
fn islands_of_rows_with_other_numbers_are_not_solved_again() {
    // As several processes number them, which hold the rows in the order of bodies.
    let mut problem = chains(&[150, 200, 300]);
    let mut solver = solver(problem.bodies);
    let mut gamma = Vec::new();
    solver.solve(&problem, &mut gamma);
    let rows_of_first = 151;
    problem.pair.rotate_left(rows_of_first);
    problem.jacobian.rotate_left(rows_of_first);
    problem.q.rotate_left(rows_of_first);
    gamma.rotate_left(rows_of_first);
    let before = gamma.clone();
    let again = solver.solve_next(&problem, &mut gamma);
    assert_eq!((again.iterations, again.products, &gamma), (0, 0, &before));
    // They go on under their new numbers.
    solver.set_settings(Settings { tolerance: 1e-9, ..SETTINGS });
    let tighter = solver.resume(&mut gamma);
    assert!(tighter.status == Status::Solved && residual(&problem, &gamma) <= 1.1e-9, "{tighter:?}");
}

#[test]
fn one_island_and_strays_are_solved_as_a_whole() {
    for links in [&[600][..], &[1_000, 5, 40], &[60, 50, 80]] {
        let problem = chains(links);
        let mut one = solver(problem.bodies);
        let mut gamma = Vec::new();
        one.solve(&problem, &mut gamma);
        assert!(!one.islands.are_used(), "{links:?}");
    }
}

#[test]
fn small_islands_are_gathered_and_large_ones_stay_alone() {
    let sizes = [0, 60, 300, 60, 0, 60, 128, 10, 20];
    let (group, count) = gather(&sizes, 600).unwrap();
    assert_eq!((group, count), (vec![NONE, 0, 1, 0, NONE, 0, 2, 3, 3], 4));
    assert_eq!(gather(&sizes, 299), None);
    assert_eq!(gather(&[500], 1_000), None);
}

#[test]
fn the_worst_island_decides_the_outcome() {
    let of = |status, residual| Outcome { status, residual, ..OPEN };
    let all = [of(Status::MaxIterations, 1e-3), of(Status::Infeasible, 1e-5), of(Status::Solved, 0.0)];
    let end = |all: &[Outcome]| Whole::default().end(all.iter(), 10);
    assert_eq!((end(&all).status, end(&all).residual), (Status::Infeasible, 1e-3));
    assert_eq!((end(&all[2..]).status, end(&all[2..]).residual), (Status::Solved, 0.0));
    let unknown = end(&[of(Status::NotFinite, f64::NAN), all[0]]);
    assert!(unknown.status == Status::NotFinite && unknown.residual.is_nan());
}

#[test]
fn an_island_without_a_solution_is_found_beside_others_which_are_solved() {
    // The last body of the first chain has the wall on its other side too, and the chain no room.
    let mut problem = chains(&[150, 400, 200]);
    let (wall, first_of_others) = (problem.bodies as u32 - 1, 151);
    problem.pair.insert(0, [150, wall]);
    problem.jacobian.insert(0, [[-1.0, -0.1, 0.0], [0.0; 3]]);
    problem.q.insert(0, -1.0);
    let mut gamma = Vec::new();
    let mut solver = solver(problem.bodies);
    let outcome = solver.solve(&problem, &mut gamma);
    assert!(solver.islands.are_used());
    let alone = Solver::new(SolverKind::Auto, SETTINGS).solve(&problem, &mut Vec::new());
    assert_eq!([outcome.status, alone.status], [Status::Infeasible; 2]);
    // As a whole they leave a row violated by as much.
    assert!(outcome.residual > 0.1 && residual(&problem, &gamma) <= 1.001 * outcome.residual, "{outcome:?}");
    assert!(residual_from(&problem, &gamma, first_of_others + 1) <= 1.001 * SETTINGS.tolerance);
    let relaxed = solver.relax(&problem, &mut gamma, 1e-5);
    assert_eq!(relaxed.status, Status::Infeasible);
    // Room for the chain: the same solver solves it.
    problem.q[0] = 1e4;
    assert_eq!(solver.solve_next(&problem, &mut gamma).status, Status::Solved);
    assert!(residual(&problem, &gamma) <= 1.001 * SETTINGS.tolerance);
}
