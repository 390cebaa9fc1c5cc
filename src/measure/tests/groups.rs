//! Groups, their mixing, and removed bodies.

use super::*;

/// A square of touching balls whose groups follow from their positions.
fn coloured(side: usize, group: impl Fn(usize, usize) -> u32) -> Snapshot {
    let mut bodies = square(side, BALL, |_| DQuat::IDENTITY);
    (0..side * side).for_each(|k| bodies.group[k] = group(k % side, k / side));
    state(bodies, None)
}

#[test]
fn a_chessboard_has_no_contact_within_a_group_and_two_halves_have_few_between() {
    let side = 20_usize;
    let (all, half) = ((side * side) as f64, (side * side / 2) as f64);
    let alike = (half - 1.0) / (all - 1.0);
    let pairs = 2.0 * (side * (side - 1)) as f64;
    let board = of("segregation", &coloured(side, |x, y| ((x + y) % 2) as u32), true);
    assert_near(value(&board, "segregation", "segregation_pairs"), pairs, 0.0);
    assert_near(value(&board, "segregation", "segregation"), 0.0, 0.0);
    assert_near(value(&board, "segregation", "assortativity"), -1.0, 1e-12);
    let halves = of("segregation", &coloured(side, |x, _| u32::from(x >= side / 2)), true);
    let own = 1.0 - side as f64 / pairs;
    assert_near(value(&halves, "segregation", "segregation_own"), own, 1e-15);
    assert_near(value(&halves, "segregation", "segregation_random"), alike, 1e-15);
    assert_near(value(&halves, "segregation", "segregation"), own / alike, 1e-14);
    assert_near(value(&halves, "segregation", "assortativity"), 2.0 * own - 1.0, 1e-14);
    let one = of_settings("segregation", &coloured(side, |_, _| NO_GROUP), true, &Settings::default());
    assert_eq!(one.unwrap_err(), LeftOut("all bodies are of one group".into()));
}

#[test]
fn a_random_mixture_is_not_segregated() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let (side, draws) = (60_usize, (0..3600).map(|_| u32::from(random.random::<f64>() < 0.3)).collect::<Vec<_>>());
    let mixed = of("segregation", &coloured(side, |x, y| draws[y * side + x]), true);
    let random = value(&mixed, "segregation", "segregation_random").unwrap();
    let pairs = value(&mixed, "segregation", "segregation_pairs").unwrap();
    // Pairs that share a body are nearly independent.
    let error = ((1.0 - random) / random / pairs).sqrt();
    assert_near(value(&mixed, "segregation", "segregation"), 1.0, 3.0 * error);
    assert_near(value(&mixed, "segregation", "assortativity"), 0.0, 4.0 / pairs.sqrt());
}

#[test]
fn groups_are_counted_with_their_lengths() {
    let mut rods = bodies((0..5).map(|k| (ROD, DVec3::X * 9.0 * k as f64, lying(0.0))));
    rods.push(Placed { shape: BALL, position: DVec3::Y * 9.0, orientation: DQuat::IDENTITY }, NO_GROUP);
    rods.group = vec![0, 0, 2, 0, NO_GROUP, 2];
    let found = of("groups", &state(rods, None), false);
    let numbers = [3.0, 3.0, 1.0, 0.5, 1.0 - (6.0 + 2.0) / 30.0];
    found.values.iter().zip(numbers).for_each(|(found, expected)| assert_near(*found, expected, 1e-15));
    let row = |group: f64, bodies: f64, length: f64| {
        vec![group, bodies, bodies / 6.0, length, 3.0].into_iter().map(Some).collect::<Vec<_>>()
    };
    assert_eq!(found.rows, [row(0.0, 1.0, 3.0), row(1.0, 3.0, 9.0), row(3.0, 2.0, 3.0)]);
}

#[test]
fn bodies_that_left_are_counted_by_rule_and_per_time() {
    let left = |removed: Vec<u64>, there: usize| {
        let mut state = state(square(10, BALL, |_| DQuat::IDENTITY), None);
        state.bodies.retain(&(0..100).map(|k| k < there).collect::<Vec<_>>());
        state.removed = removed;
        let removes = Frame { removes: true, ..frame(true) };
        select(&["removal".into()]).unwrap()[0].of(&View::new(&state, &removes, &Settings::default()))
    };
    let mut found = [left(Vec::new(), 100), left(vec![10, 0], 90), left(vec![12, 8], 80)];
    removal::Removed.over_time(&[0.0, 0.5, 1.5], &mut found);
    let numbers = found.map(|found| found.unwrap().values);
    assert_eq!(numbers[0], [Some(0.0), Some(0.0), None]);
    assert_eq!(numbers[1], [Some(10.0), Some(0.1), Some(20.0)]);
    assert_eq!(numbers[2], [Some(20.0), Some(0.2), Some(10.0)]);
    let none = of_settings("removal", &coloured(2, |_, _| 0), true, &Settings::default());
    assert_eq!(none.unwrap_err(), LeftOut("the scene removes no bodies".into()));
}
