use super::super::{Size, attempts_csv, page, plot, runs_csv, solvers};
use super::*;
use relcp::lcp::Problem;

fn within(iterations: u64) -> Size {
    Size { iterations, ..Size::FULL }
}

/// A row of bodies that push each other apart, with a repeated contact; a solution by the exact solver.
fn chain(bodies: usize) -> Named {
    let mut problem = Problem::<3> { bodies, ..Problem::default() };
    for body in 1..bodies as u32 {
        for turn in [0.0, 0.3] {
            problem.pair.push([body - 1, body]);
            problem.jacobian.push([[-1.0, 0.1 * turn, turn], [1.0, 0.0, 0.5 * turn]]);
            problem.q.push(-0.1 - 0.05 * turn);
        }
    }
    let mut gamma = Vec::new();
    let settings = Settings { tolerance: 1e-12, max_iterations: 10_000 };
    let outcome = Solver::new(SolverKind::Dense, settings).solve(&problem, &mut gamma);
    assert_eq!(outcome.status, Status::Solved);
    let start = gamma.iter().map(|x| 0.9 * x).collect();
    Named { name: "chain".into(), lcp: Stored::new(&problem, start, &gamma) }
}

#[test]
fn every_solver_is_measured_from_both_starts_to_all_residuals() {
    let named = chain(12);
    let instance = measure(&named, &[Compute::Cpu], &within(20_000)).unwrap();
    assert_eq!((instance.rows, instance.pairs, instance.reference), (22, 11, Reference::Stored));
    assert_eq!(instance.attempts.len(), solvers().len() * 2 * TOLERANCES.len());
    let mut errors = Vec::new();
    for attempt in instance.attempts.iter().filter(|attempt| attempt.refused.is_none()) {
        assert_eq!(attempt.status, "solved", "{attempt:?}");
        assert!(attempt.residual.unwrap() <= attempt.tolerance * (1.0 + 1e-6), "{attempt:?}");
        assert!(attempt.products >= 1, "{attempt:?}");
        errors.push((attempt.tolerance, attempt.velocity_error.unwrap()));
    }
    // The velocity is unique: a tighter residual brings every solver nearer to the stored one.
    let worst = |at: f64| errors.iter().filter(|(of, _)| *of == at).fold(0.0_f64, |worst, (_, e)| worst.max(*e));
    assert!(worst(1e-6) < 1e-4 && worst(1e-6) < worst(1e-3), "{errors:?}");
    // The exact solver has no history; each other has one a start, which ends where the tightest solve did.
    assert!(instance.curves.len() >= 2 * 5);
    for curve in &instance.curves {
        let same = |a: &&Attempt| (&a.solver, a.start) == (&curve.solver, curve.start) && a.tolerance == 1e-6;
        let attempt = instance.attempts.iter().find(same).unwrap();
        let (products, residual) = *curve.points.last().unwrap();
        assert!(products <= attempt.products && residual <= 1e-6, "{curve:?}");
    }
}

#[test]
fn a_solve_that_is_not_repeated_is_what_it_would_have_been() {
    let named = chain(12);
    let instance = measure(&named, &[Compute::Cpu], &within(5)).unwrap();
    assert!(instance.attempts.iter().any(|attempt| attempt.status == "max_iterations"));
    for attempt in &instance.attempts {
        let kind = solvers().into_iter().find(|(name, _)| *name == attempt.solver).unwrap().1;
        let settings = Settings { tolerance: attempt.tolerance, max_iterations: 5 };
        let Ok(again) = solve(&named.lcp, kind, attempt.start, settings, &Compute::Cpu).unwrap() else { continue };
        let outcome = again.outcome;
        assert_eq!(
            (outcome.status.name(), outcome.products),
            (attempt.status.as_str(), attempt.products),
            "{attempt:?}"
        );
        assert_eq!(Some(named.lcp.residual(&again.gamma)), attempt.residual, "{attempt:?}");
    }
}

#[test]
fn a_poor_stored_solution_is_not_what_velocities_are_compared_with() {
    let solved = chain(6);
    let mut named = solved.clone();
    named.lcp.gamma.iter_mut().for_each(|x| *x *= 0.5);
    named.lcp.velocity.iter_mut().for_each(|v| *v *= 0.5);
    let (reference, v) = reference(&named.lcp).unwrap();
    assert_eq!(reference, Reference::Made);
    assert!(error(&v.unwrap(), &solved.lcp.velocity) < 1e-8);
    // Two bodies that a pair of opposite rows want both nearer and farther: there is no solution.
    let contradiction = Problem::<3> {
        bodies: 2,
        pair: vec![[0, 1], [0, 1]],
        jacobian: vec![[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]],
        q: vec![-0.1, -0.1],
        ..Problem::default()
    };
    named.lcp = Stored::new(&contradiction, vec![0.0; 2], &[0.0; 2]);
    let instance = measure(&named, &[Compute::Cpu], &within(100)).unwrap();
    assert_eq!(instance.reference, Reference::None);
    assert!(instance.attempts.iter().all(|attempt| attempt.status != "solved" && attempt.velocity_error.is_none()));
}

#[test]
fn numbers_that_are_not_finite_are_told() {
    let mut named = chain(4);
    named.lcp.q[1] = f64::NAN;
    let instance = measure(&named, &[Compute::Cpu], &within(100)).unwrap();
    assert_eq!((instance.stored_residual, instance.reference), (None, Reference::None));
    assert!(instance.attempts.iter().all(|a| a.status == "not_finite" || a.refused.is_some()), "{instance:?}");
    assert!(page(&[instance], &[], &Size::QUICK).contains("not finite"));
}

#[test]
fn page_tables_and_plot_say_what_was_measured() {
    // Far apart, so that the number of rows is a problem only for the exact solver.
    let bodies = Size::FULL.rows_of_dense as u32 + 2;
    let mut problem = Problem::<3> { bodies: bodies as usize, ..Problem::default() };
    for body in 1..bodies {
        problem.pair.push([body - 1, body]);
        problem.jacobian.push([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        problem.q.push(if body % 2 == 0 { -0.1 } else { 1.0 });
    }
    let zero = vec![0.0; problem.q.len()];
    let named = Named { name: "open <chain>".into(), lcp: Stored::new(&problem, zero.clone(), &zero) };
    let instance = measure(&named, &[Compute::Cpu], &within(2_000)).unwrap();
    let dense: Vec<&Attempt> = instance.attempts.iter().filter(|a| a.solver == "dense").collect();
    assert!(dense.iter().all(|a| a.status == "refused" && a.refused.as_ref().unwrap().contains("1000 rows")));
    let instances = [instance];
    let text = page(&instances, &[], &Size::FULL);
    let csv = String::from_utf8(attempts_csv(&instances).unwrap()).unwrap();
    let svg = plot(&instances[0]).unwrap().svg();
    assert!(text.contains("Refused: dense: too large, it is given at most 1000 rows."), "{text}");
    assert_eq!(csv.lines().count(), 1 + instances[0].attempts.len());
    assert!(csv.starts_with("lcp,solver,computed_by,start,tolerance,status,refused,"), "{csv}");
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert!(svg.contains("open &lt;chain&gt;") && svg.contains("warm start"));
    for (solver, _) in solvers() {
        assert!(text.contains(&format!("| {solver} | cold |")), "{solver}");
        assert_eq!(svg.contains(&solver), solver != "dense", "{solver}");
    }
    assert_eq!(runs_csv(&[]).unwrap(), b"");
}

#[test]
fn a_plot_of_nothing_is_a_plot() {
    let named = Named { name: "empty".into(), lcp: Stored { unknowns: 6, ..Stored::default() } };
    let instance = measure(&named, &[Compute::Cpu], &within(10)).unwrap();
    assert!(plot(&instance).unwrap().svg().contains("empty: 0 rows"));
    assert!(plot(&Instance { curves: Vec::new(), ..instance }).unwrap().svg().ends_with("</svg>\n"));
}

#[test]
fn a_long_history_keeps_its_ends_and_never_rises() {
    let history: Vec<ResidualSample> = (0..50_000)
        .map(|i| ResidualSample {
            iterations: i,
            products: i + 1,
            residual: 1.0 / (1.0 + i as f64) + f64::from(i % 7 == 3),
        })
        .collect();
    let points = thinned(&history);
    assert!(points.len() <= MOST_POINTS + 20, "{}", points.len());
    assert_eq!((points[0], points.last().unwrap().0), ((1, 1.0), 50_000));
    assert!(points.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 >= w[1].1));
    assert_eq!(thinned(&[]), []);
}

#[test]
fn the_error_is_relative_where_it_can_be() {
    assert_eq!(error(&[3.0, 0.0], &[0.0, 0.0]), 3.0);
    assert_eq!(error(&[3.0, 5.0], &[3.0, 4.0]), 0.2);
}
