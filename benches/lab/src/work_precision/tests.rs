use super::*;
use relcp::scene::{Method, Stepping};

fn row(curve: &str, steps: u64, error: Option<f64>, wall_seconds: f64) -> Row {
    Row {
        problem: "two-ellipsoids",
        method: "ReLCP".into(),
        stepping: if curve.contains("midpoint") { Stepping::Midpoint } else { Stepping::Euler },
        sweep: Sweep::Step,
        curve: curve.into(),
        computed_by: "CPU f64, 1 threads".into(),
        machine: "a machine".into(),
        dt: 40.0 / steps as f64,
        steps,
        overlap_tolerance: 1e-5,
        error,
        position_error: error,
        angle_error: error.map(|error| 0.5 * error),
        certain: true,
        order: None,
        max_overlap: 1e-6,
        products: 10 * steps,
        iterations: 9 * steps,
        recursions: 0,
        constraints: 1.0,
        wall_seconds,
        unconverged: 0,
    }
}

#[test]
fn every_stored_reference_is_of_its_scene_and_two_schemes_agree_on_it() {
    let mut names = Vec::new();
    for problem in PROBLEMS {
        let reference = Reference::stored(&problem).unwrap();
        assert_eq!((&*reference.problem, reference.made), (problem.name, problem.making));
        assert_eq!((reference.time, reference.unconverged), (problem.end, 0), "{}", problem.name);
        assert!(reference.estimate.worst() <= 1e-4, "{}: {:?}", problem.name, reference.estimate);
        // Another end, or another start, is another problem.
        let hash = problem.hash().unwrap();
        assert_ne!(Problem { end: 2.0 * problem.end, ..problem }.hash().unwrap(), hash);
        assert_ne!(
            Problem { sets: &["bodies.0.position=[0.5,3,0]"], scene: "two-ellipsoids", ..problem }.hash().unwrap(),
            hash
        );
        // Steps are no part of it.
        assert_eq!(Problem { coarsest: 2 * problem.coarsest, ..problem }.hash().unwrap(), hash);
        names.push(problem.name);
    }
    names.dedup();
    assert_eq!(names.len(), PROBLEMS.len());
}

/// Runs that were not part of making a reference come as near to it as is said here, and refining a step brings an end
/// nearer.
#[test]
fn modest_runs_come_near_the_references() {
    let modest: [(&str, Stepping, [u64; 2], f64); 5] = [
        ("two-ellipsoids", Stepping::Midpoint, [200, 800], 5e-5),
        ("three-capsules", Stepping::Euler, [25, 400], 1e-4),
        ("compaction", Stepping::Midpoint, [50, 400], 1e-3),
        ("colony", Stepping::Midpoint, [256, 1024], 1e-3),
        ("chainmail", Stepping::Midpoint, [16, 64], 5e-4),
    ];
    for (problem, (name, stepping, steps, bound)) in PROBLEMS.iter().zip(modest) {
        assert_eq!(problem.name, name);
        let reference = Reference::stored(problem).unwrap();
        let [coarse, fine] = steps.map(|steps| {
            let (method, sweep, overlap_tolerance) = (Method::Relcp, Sweep::Step, 1e-6);
            let case = Case { method, stepping, sweep, steps, overlap_tolerance };
            let row = run(problem, &reference, &case, &Compute::Cpu).unwrap();
            assert!(!row.missed() && row.steps == steps && row.products > 0, "{row:?}");
            row.error.unwrap()
        });
        assert!(fine < coarse && fine <= bound, "{name}: {coarse:.1e}, {fine:.1e}");
    }
}

#[test]
fn a_reference_is_made_as_it_is_stored() {
    let problem = &PROBLEMS[0];
    let stored = Reference::stored(problem).unwrap();
    // Coarser than the stored one, with an estimate of error that covers the distance to it.
    let made = Making { midpoint_steps: 1600, euler_steps: 3200, ..problem.making };
    let own = Reference::make(problem, made).unwrap();
    let away = stored.error(&own.bodies).unwrap().worst();
    assert!(away > 0.0 && away < 2.0 * own.estimate.worst() && own.estimate.worst() < 1e-3, "{away:.1e} {own:?}");
    assert_eq!((own.hash, own.length, own.unconverged), (stored.hash, 4.0, 0));
}

#[test]
fn costs_are_from_where_on_a_curve_stays_within_an_error() {
    // Costs 1, 2, 4, 8 and 16, one of them exact by chance.
    let errors = [1e-1, 1e-4, 1e-2, 1e-3, 1e-4];
    let rows: Vec<Row> =
        errors.iter().zip(0..).map(|(error, k)| row("ReLCP", 100 << k, Some(*error), f64::from(1 << k))).collect();
    let all = curves(&rows);
    let [curve] = &all[..] else { panic!("{all:?}") };
    let cost = |error: f64| curve.cost(error, |row| row.wall_seconds);
    let near = |cost: Option<Cost>, value: f64| {
        cost.is_some_and(|cost| !cost.at_most && (cost.value / value - 1.0).abs() < 1e-12)
    };
    assert!(near(cost(1e-3), 8.0) && near(cost(10f64.powf(-3.5)), 8.0 * 2f64.sqrt()), "{:?}", cost(1e-3));
    assert_eq!((cost(0.5), cost(1e-5)), (Some(Cost { value: 1.0, at_most: true }), None));
    // Other bodies than the reference's are no error at all.
    let rows = [row("ReLCP", 100, None, 1.0), row("ReLCP", 200, Some(1e-3), 2.0)];
    let cost = |error: f64| curves(&rows)[0].cost(error, |row| row.wall_seconds);
    assert_eq!((cost(1e-2), cost(1e-4)), (Some(Cost { value: 2.0, at_most: true }), None));
}

/// A study of made-up rows: errors of first order of the paper's step and of second of midpoint steps.
fn made_up() -> Study {
    let mut study = Study::begin(Size::QUICK, vec![Compute::Cpu]).unwrap();
    for (curve, order) in [("ReLCP", 1.0), ("ReLCP, midpoint", 2.0)] {
        for k in 0..4 {
            let error = 0.1 * 0.1f64.powf(order * f64::from(k));
            study.push(row(curve, 100 * 10u64.pow(k), Some(error), 1e-3 * 10f64.powf(f64::from(k))));
        }
    }
    let swept = Row { sweep: Sweep::Tolerance, ..row("ReLCP, tolerance at 400 steps", 400, Some(1e-9), 1e-9) };
    study.push(swept);
    study
}

#[test]
fn the_page_tells_the_cheapest_ways_and_what_is_missed() {
    let mut study = made_up();
    let orders: Vec<Option<f64>> = study.rows().iter().map(|row| row.order.map(f64::round)).collect();
    let [first, second] = [Some(1.0), Some(2.0)];
    assert_eq!(orders, [None, first, first, first, None, second, second, second, None]);
    let page = study.page();
    for part in [
        // 0.1 at 1 ms and 1e-3 at 10 ms: 1e-2 between them; a sweep of tolerances is no way there, however cheap.
        "| two-ellipsoids | 1e-2 | ReLCP, midpoint | 3.16 ms | 1.0e-6 | ReLCP, midpoint | 3162 | 1.0e-6 |",
        "| two-ellipsoids | 1e-5 | ReLCP, midpoint | 100 ms | 1.0e-6 | ReLCP, midpoint | 100000 | 1.0e-6 |",
        "| ReLCP | 10.0 ms, 10000 | 100 ms, 100000 |",
        "10.00 times less: 100 ms against 10.0 ms | yes |",
        "| ReLCP, midpoint | CPU f64, 1 threads | 1000 | 1.0e-5 | 1.00e-3 | 2.00 |",
        "all of 9 | yes |",
        // What is under three times the reference's own error is said to be.
        "| compaction | ~1e-5 |",
        "| colony | 1e-2 |  |  |  |  |  |  |",
        "neither gets there | not measured |",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
    assert!(!study.missed());
    study.push(Row { max_overlap: 2e-5, certain: false, ..row("ReLCP", 100, None, 1.0) });
    let page = study.page();
    assert!(study.missed() && page.contains("1 of 10 do not, the first two-ellipsoids, ReLCP, 100 steps | **no** |"));
    assert!(page.contains("| ~other bodies |"), "{page}");
    assert_eq!(study.files().unwrap()[0].1.split(|byte| *byte == b'\n').count(), 12);
    let plots = study.plots().unwrap();
    assert!(plots.len() == PROBLEMS.len() && plots.iter().all(|(_, figure)| figure.svg().starts_with("<svg")));
    assert_eq!(study.numbers().unwrap()["best"].as_array().unwrap().len(), ERRORS.len() * PROBLEMS.len());
}

#[test]
fn every_run_ends_at_the_problems_end_in_every_size() {
    for size in [Size::FULL, Size::QUICK] {
        for problem in PROBLEMS {
            let cases = size.cases(&problem);
            let count = |what: &dyn Fn(&&Case) -> bool| cases.iter().filter(what).count() as u32;
            assert_eq!(count(&|case| case.sweep == Sweep::Tolerance), 2 * size.tolerances);
            assert_eq!(count(&|case| case.sweep == Sweep::Both), size.both + size.both.min(6));
            assert!(cases.iter().all(|case| case.steps <= problem.coarsest << 10));
            for case in &cases {
                let scene = case.scene(&problem).unwrap();
                assert_eq!((scene.time.steps(), scene.contact.cutoff), (case.steps, None));
                assert!((scene.time.after(case.steps) - problem.end).abs() < 1e-12);
                // The tightest stays above what positions of this size are rounded to.
                assert!((1e-8..=1e-3).contains(&scene.contact.overlap_tolerance), "{case:?}");
            }
            // No two runs of a curve are the same.
            let same = |a: &Case, b: &Case| a == b;
            assert!(cases.iter().enumerate().all(|(k, case)| !cases[..k].iter().any(|other| same(other, case))));
        }
    }
}
