use super::*;

#[test]
fn chambers_are_drawn_as_they_are_described() {
    let drawn: Vec<Chamber> = (0..200).map(|number| chamber(1, number, false)).collect();
    for Chamber { number, width, height, tilt, scene } in &drawn {
        assert!(scene.build().is_ok_and(|bodies| bodies.len() == 1), "{number}");
        assert_eq!(Scene::parse(&scene.to_json(), "again").unwrap(), *scene, "{number}");
        assert!((5.0..=20.0).contains(width) && (10.0..=20.0).contains(height) && tilt.abs() <= 15.0, "{number}");
        let growth = &scene.growth[0];
        let [rate, added, turn] = [growth.rate_noise, growth.added_length_noise, growth.reorientation_degrees];
        assert!(rate <= 0.2 && added <= 0.2 && turn <= 5.0 && (5e-4..=5e-3).contains(&scene.time.dt), "{number}");
        let founder = scene.bodies[0].position;
        assert!(founder[1] - (founder[0] * tilt.to_radians().tan()) < 1.7, "{number}: {founder:?}");
    }
    let count = |is: fn(&Chamber) -> bool| drawn.iter().filter(|chamber| is(chamber)).count();
    let halves = [count(|chamber| chamber.width.fract() == 0.0), count(|chamber| chamber.tilt == 0.0)];
    assert!(halves.iter().all(|half| (80..=120).contains(half)), "{halves:?}");
}

#[test]
fn stalling_changes_nothing_else() {
    let (mut stops, stalls) = (chamber(3, 5, false), chamber(3, 5, true));
    assert!(stops != stalls && stops != chamber(4, 5, false));
    stops.scene.growth[0].on_no_room = OnNoRoom::Stall;
    assert_eq!(stops, stalls);
}

/// Returns the measurements without wall times.
fn without_times(rows: &[Row]) -> Vec<Row> {
    let bare = |row: &Row| Row {
        seconds: 0.0,
        seconds_at_60: None,
        seconds_at_120: None,
        seconds_at_300: None,
        ..row.clone()
    };
    rows.iter().map(bare).collect()
}

#[test]
fn chambers_get_the_same_rows_on_any_number_of_threads() {
    let rows = run_all([2, 4], false, 300, 2, &|_, _| ()).unwrap();
    assert_eq!(without_times(&rows), without_times(&run_all([2, 4], false, 300, 1, &|_, _| ()).unwrap()));
    let numbers: Vec<u64> = rows.iter().map(|row| row.number).collect();
    assert_eq!(numbers, [0, 1, 2, 3]);
    assert!(rows.iter().all(|row| row.steps == 300 && row.end == End::Steps && row.is_well()), "{rows:?}");
    // A cell alone grows where it is.
    assert!(rows.iter().all(|row| row.solves >= 1.0) && rows.iter().any(|row| row.largest_move > 0.0), "{rows:?}");
    let page = page(&rows, 2, false);
    assert!(page.contains("| steps | 4 |") && page.contains("4 chambers overflowed"), "{page}");
    assert_eq!(String::from_utf8(csv(&rows).unwrap()).unwrap().lines().count(), 5);
}

#[test]
fn a_low_chamber_overflows_for_two_generations() {
    let mut low = chamber(1, 0, false);
    // So low that the founder's daughters leave.
    low.scene.removal = vec![Removal::outside(Wall::HalfSpace {
        normal: [0.0, -1.0, 0.0],
        offset: -4.0,
        motion: None,
        friction: None,
        load: None,
    })];
    low.scene.time.dt = 5e-3;
    let row = run(&low, u64::MAX);
    assert_eq!(row.end, End::Overflowed, "{row:?}");
    assert!(row.removed > 0 && row.most_leaving > 0 && row.time > overflowing(), "{row:?}");
}
