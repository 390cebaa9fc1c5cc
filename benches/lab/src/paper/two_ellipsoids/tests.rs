use super::targets::{PAPER_EULER, PAPER_MULTISPHERE};
use super::*;
use glam::{DQuat, DVec3};
use relcp::separation::Placed;
use relcp::shape::Shape;
use std::f64::consts::{FRAC_PI_2, PI};

/// A study of paths that are known, with an error `C dt^p` added.
fn made_up() -> Study {
    let size = Size { euler: &[1e-1, 1e-2], midpoint: &[0.4, 0.2], spheres: &[], ..Size::QUICK };
    let right = |case: &Case| case.side == Side::Right;
    let path = |error: f64| {
        let time = (0..=400).map(|k| 0.1 * f64::from(k));
        Path { interval: 0.1, samples: [1.0, 2.0, 0.5].map(|part| time.clone().map(|t| t + part * error).collect()) }
    };
    let run = |case: Case| {
        let order = if case.scheme == Scheme::Midpoint { 2.0 } else { 1.0 };
        Run {
            case,
            path: path(case.dt.powf(order)),
            steps: 1,
            time: std::time::Duration::from_secs_f64(1e-3 / case.dt),
            products: (1.0 / case.dt) as u64,
            recursions: 0,
            constraints: 1,
            max_overlap: 0.0,
            proxy_overlap: None,
            unconverged: 0,
        }
    };
    let reference = |side| Reference {
        side,
        path: path(0.0),
        midpoint_dt: 0.0,
        euler_dt: 0.0,
        tight_overlap_tolerance: 1e-9,
        tight_solver_tolerance: 1e-10,
        overlap_tolerance: 1e-5,
        solver_tolerance: 1e-6,
        difference: [1e-9; 3],
    };
    let runs = size.cases().into_iter().filter(right).map(run).collect();
    Study { size, references: [reference(Side::Right), reference(Side::Left)], runs }
}

#[test]
fn rows_have_the_errors_and_orders_of_known_paths() {
    let study = made_up();
    let rows = study.rows();
    assert_eq!(rows.len(), 4);
    for row in &rows {
        // A constant error over 40 time units.
        let of_y = 2.0 * row.dt.powi(if row.scheme == Scheme::Midpoint { 2 } else { 1 }) * 40f64.sqrt();
        assert!((row.y / of_y - 1.0).abs() < 1e-9 && (row.x - 0.5 * of_y).abs() < 1e-9 && row.worst == row.y);
        // The norm of t over 40 time units is 40^1.5 / sqrt(3), but for the trapezoidal rule.
        assert!((row.relative_y / (row.y / (40f64.powi(3) / 3.0).sqrt()) - 1.0).abs() < 1e-4);
    }
    let orders: Vec<Option<f64>> = rows.iter().map(|row| row.order.map(|order| (1e6 * order).round() / 1e6)).collect();
    assert_eq!(orders, [None, Some(2.0), None, Some(1.0)]);
    // Against the finest of the paper's steps an error of 0.1 is one of 0.09.
    assert!((rows[2].x_to_finest.unwrap() / rows[2].x - 0.9).abs() < 1e-9 && rows[3].x_to_finest == Some(0.0));
    let page = study.page();
    assert!(
        page.contains("| 1e-1 | 6.32e-1 | 1.26e0 | 3.16e-1 |  | 0.5692, 1.1384, 0.2846 | 2.4530, 1.0111, 0.1078 |"),
        "{page}"
    );
    assert!(
        page.contains("| falls by 8 to 12 a decade")
            || page.contains("falls by 8 to 12 a decade of dt | 10.00 | yes |")
    );
    assert_eq!(String::from_utf8(study.csv().unwrap()).unwrap().lines().count(), 5);
}

#[test]
fn targets_that_are_missed_are_said_to_be() {
    let mut study = made_up();
    let met = |study: &Study| study.targets().iter().map(|target| target.met).collect::<Vec<_>>();
    // Errors of y are 1.25 times the paper's at 0.1, and no sub-spheres were run.
    assert_eq!(met(&study)[..7], [None, None, None, Some(false), Some(true), None, Some(true)]);
    assert!(!study.missed());
    let worse = study.runs[0].path.clone();
    study.runs[1].path = worse;
    study.runs[3].max_overlap = 2e-5;
    assert_eq!([3, 4, 6].map(|at| met(&study)[at]), [Some(false), Some(true), Some(false)]);
    assert!(study.missed());
}

#[test]
fn an_axis_is_followed_through_turns() {
    let mut path = Path::new(0.1);
    let shape = Shape::Sphere { radius: 1.0 };
    let turns: Vec<f64> = (0..60).map(|k| 0.7 - 0.2 * f64::from(k)).collect();
    for (k, turn) in turns.iter().enumerate() {
        // The axis may point either way.
        let turn = turn + if k % 2 == 0 { PI } else { 0.0 };
        let orientation = DQuat::from_rotation_z(turn) * DQuat::from_rotation_y(FRAC_PI_2);
        path.push(&Placed { shape, position: DVec3::new(1.0, 2.0, 0.0), orientation });
    }
    assert!(path.samples[2].iter().zip(&turns).all(|(found, turn)| (found - turn).abs() < 1e-12));
    assert_eq!(path.every(0.3).samples[2].len(), 20);
    assert!((path.every(0.3).interval - 0.3).abs() < 1e-12);
}

#[test]
fn runs_are_sampled_at_the_same_times_whatever_their_steps() {
    let first = |scheme, dt| {
        let case = Case { scheme, dt, spheres: None, side: Side::Right };
        follow(case).unwrap()
    };
    let (coarse, fine) = (first(Scheme::Midpoint, 0.4), first(Scheme::Midpoint, 0.05));
    assert_eq!((coarse.path.samples[0].len(), fine.path.samples[0].len(), fine.steps), (101, 401, 800));
    // Before contact both fall at a speed of a quarter.
    for (path, k) in [(&coarse.path, 9), (&fine.path, 36)] {
        assert!((path.samples[1][k] - (2.5 - 0.25 * 3.6)).abs() < 1e-12, "{}", path.samples[1][k]);
    }
    assert!(coarse.path.errors(&fine.path).iter().all(|error| *error > 0.0 && *error < 0.1));
    assert!(coarse.products > 0 && coarse.max_overlap <= 1e-5);
}

#[test]
fn every_step_that_is_measured_has_samples_at_common_times() {
    for size in [Size::FULL, Size::QUICK] {
        let side = Side::Left;
        let reference = Case { scheme: Scheme::Midpoint, dt: size.reference_midpoint, spheres: None, side };
        let half = Case { scheme: Scheme::Euler, dt: 0.5 * size.reference_euler, spheres: None, side };
        for case in size.cases().into_iter().chain([reference, half]) {
            let strides = (0.1 / case.dt).max(case.dt / 0.1);
            assert!((strides - strides.round()).abs() < 1e-9, "{case:?}");
        }
    }
    // What the page compares with the paper's figures is among them.
    assert!(PAPER_EULER.iter().all(|(dt, _)| Size::FULL.euler.contains(dt)));
    assert!(PAPER_MULTISPHERE.iter().all(|(count, _)| Size::FULL.spheres.contains(count)));
}
