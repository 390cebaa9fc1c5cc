//! Measures of motion of states with known answers.

use super::*;
use crate::fixed::Fixed;
use crate::periodic::Periods;

/// The values and rows of `msd` over states at these times.
fn msd(times: &[f64], fixed: &Fixed, states: impl Fn(f64) -> Bodies) -> Vec<Result<Found, LeftOut>> {
    let measure = select(&["msd".into()]).unwrap()[0];
    let mut tracks = Tracks::new(times.len(), 1);
    let mut found = Vec::new();
    for t in times {
        let bodies = states(*t);
        tracks.push(&bodies, fixed);
        found.push(measure.of(&View::new(&state(bodies, None), &frame(false), &Settings::default())));
    }
    measure.along(times, &tracks, &mut found);
    found
}

fn cells(row: &[Cell]) -> [f64; 8] {
    std::array::from_fn(|k| row[k].unwrap())
}

/// Two bodies that move and turn steadily, one twice as fast, far beyond a whole turn and the cell.
fn steady(t: f64) -> Bodies {
    let mut moving = bodies([1.0, 2.0].map(|fast| {
        let turned = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.5 * fast * t);
        (ROD, DVec3::new(3.0 * fast * t, fast, 0.0), turned)
    }));
    moving.periods = Periods::new([Some(2.5), None, None]);
    moving.velocity = vec![DVec3::new((0.4 * t).cos(), (0.4 * t).sin(), 0.0); 2];
    moving
}

#[test]
fn steady_motion_has_the_square_of_its_way_and_turn_in_periods_too() {
    let times: Vec<f64> = (0..21).map(|k| 0.5 * f64::from(k)).collect();
    let found = msd(&times, &Fixed::default(), steady);
    let last = found[20].as_ref().unwrap();
    assert_eq!((last.rows.len(), &last.remark), (20, &None));
    for (k, row) in last.rows.iter().map(|row| cells(row)).enumerate() {
        let lag = times[k + 1];
        let mean = |rate: f64| 2.5 * (rate * lag).powi(2);
        let expected = [lag, mean(3.0), 0.6 * mean(3.0), mean(1.5), 0.6 * mean(1.5), (0.4 * lag).cos(), 2.0];
        for (found, expected) in row.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{row:?} {expected}");
        }
        assert_eq!(row[7], 2.0 * (20 - k) as f64);
    }
    for (t, found) in times.iter().zip(&found) {
        let values = &found.as_ref().unwrap().values;
        assert!((values[0].unwrap() - 22.5 * t * t).abs() < 1e-9 && values[2] == Some(2.0), "{values:?}");
    }
    // A fixed body does not count.
    let one = msd(&times, &Fixed::new(vec![1], vec![]), steady);
    let row = &one[20].as_ref().unwrap().rows[3];
    assert_near(row[1], 36.0, 1e-9);
    assert_eq!((row[2], row[6]), (None, Some(1.0)));
}

#[test]
fn bodies_are_followed_from_birth_to_division_and_odd_times_have_rows_of_their_own() {
    // At time 2 body 0 divides into ids 1 and 2.
    let divided = |t: f64| {
        let mut all =
            bodies((0..if t < 2.0 { 1 } else { 2 }).map(|k| (BALL, DVec3::X * (t + k as f64), DQuat::IDENTITY)));
        for (k, lineage) in all.lineage.iter_mut().enumerate().filter(|_| t >= 2.0) {
            lineage.id = 1 + k as u64;
        }
        all
    };
    let found = msd(&[0.0, 1.0, 2.0, 3.0, 3.25], &Fixed::default(), divided);
    let last = found[4].as_ref().unwrap();
    let rows: Vec<[f64; 3]> = last.rows.iter().map(|row| [0, 1, 7].map(|k| row[k].unwrap())).collect();
    assert_eq!(rows, [[0.25, 0.0625, 2.0], [1.0, 1.0, 3.0], [1.25, 1.5625, 2.0]]);
    assert!(last.rows.iter().all(|row| row[5].is_none()), "at rest no body has a direction");
    assert_eq!(last.values, [None, None, Some(0.0)]);
    assert_eq!(found[1].as_ref().unwrap().values, [Some(1.0), Some(0.0), Some(1.0)]);
}

#[test]
fn of_many_bodies_the_same_ones_are_followed() {
    let crowd = |t: f64| bodies((0..6000).map(|k| (BALL, DVec3::Y * k as f64 * t, DQuat::IDENTITY)));
    let found = msd(&[0.0, 1.0, 2.0], &Fixed::default(), crowd);
    let last = found[2].as_ref().unwrap();
    assert!(last.remark.as_ref().unwrap().contains("4096 bodies are followed"), "{:?}", last.remark);
    let row = cells(&[&last.rows[0][..5], &[Some(1.0)], &last.rows[0][6..]].concat());
    assert_eq!(row[6..], [4096.0, 8192.0]);
    // The mean of the squares of 0 to 5999, within four standard errors.
    assert!((row[1] - 5999.0 * 11_999.0 / 6.0).abs() < 4.0 * row[2], "{row:?}");
}

#[test]
fn one_state_has_no_lag() {
    let found = msd(&[1.0], &Fixed::default(), steady);
    let found = found[0].as_ref().unwrap();
    assert!(found.rows.is_empty() && found.remark.as_ref().unwrap().contains("no lag"));
}

#[test]
fn velocities_that_turn_along_a_row_are_correlated_as_the_cosine() {
    let turn = 0.02;
    let mut row = bodies((0..300).map(|k| (BALL, DVec3::X * k as f64, DQuat::IDENTITY)));
    for (k, v) in row.velocity.iter_mut().enumerate() {
        let angle = turn * k as f64;
        *v = 2.0 * DVec3::new(angle.cos(), angle.sin(), 0.0);
    }
    let of_row = of("velocity_correlation", &state(row.clone(), None), true);
    let number = |column| value(&of_row, "velocity_correlation", column);
    for row in &of_row.rows[..of_row.rows.len() - 1] {
        let [r, c] = [row[0].unwrap(), row[1].unwrap()];
        assert!((c - (turn * r).cos()).abs() < 1e-12, "{r}: {c}");
    }
    assert_near(number("velocity_correlation_length"), (1.0 / E).acos() / turn, 0.01);
    assert_near(number("speed_mean"), 2.0, 1e-14);
    // The sum of a geometric series of unit vectors.
    assert_near(number("velocity_order"), ((150.0 * turn).sin() / (0.5 * turn).sin() / 300.0).abs(), 1e-12);
    assert_eq!(number("velocity_correlation_pairs"), Some(150.0 * 299.0));
    // Bodies at rest are left out, and opposite velocities are anticorrelated.
    row.velocity.fill(DVec3::ZERO);
    (row.velocity[7], row.velocity[10]) = (DVec3::Y, -DVec3::Y);
    let two = of("velocity_correlation", &state(row.clone(), None), true);
    assert_eq!(two.rows, [[3.0, -1.0, 1.0].map(Some)]);
    assert_eq!(two.values[1..4], [0.0, 1.0, 2.0].map(Some));
    row.velocity.fill(DVec3::ZERO);
    let still = of_settings("velocity_correlation", &state(row.clone(), None), true, &Settings::default());
    assert!(still.unwrap_err().0.contains("no body moves"));
    row.velocity[3] = DVec3::Y;
    let alone = of("velocity_correlation", &state(row, None), true);
    assert!(alone.rows.is_empty() && alone.values[3] == Some(1.0) && alone.remark.unwrap().contains("single body"));
}
