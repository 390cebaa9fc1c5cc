//! Orientational order, local and global, and microdomains.

use super::*;

fn random_axes(count: usize, planar: bool, seed: u64) -> Snapshot {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || random.random::<f64>();
    let turn = |draw: &mut dyn FnMut() -> f64| {
        if planar {
            return lying(TAU * draw());
        }
        let (z, angle) = (2.0 * draw() - 1.0, TAU * draw());
        let flat = (1.0 - z * z).sqrt();
        DQuat::from_rotation_arc(DVec3::Z, DVec3::new(flat * angle.cos(), flat * angle.sin(), z))
    };
    state(bodies((0..count).map(|k| (ROD, DVec3::X * k as f64, turn(&mut draw)))), None)
}

#[test]
fn aligned_bodies_have_order_one() {
    for planar in [true, false] {
        let state = state(square(6, ROD, |_| lying(0.3)), None);
        let found = of("nematic", &state, planar);
        assert_near(value(&found, "nematic", "nematic_order"), 1.0, 1e-14);
        assert_near(value(&found, "nematic", "nematic_local"), 1.0, 1e-14);
        let director = value(&found, "nematic", "nematic_director_degrees");
        assert_eq!(director.is_some(), planar);
        director.into_iter().for_each(|degrees| assert!((degrees - 0.3_f64.to_degrees()).abs() < 1e-10));
        let found = of("correlation", &state, planar);
        assert!(found.rows.len() > 5 && found.rows.iter().all(|row| (row[1].unwrap() - 1.0).abs() < 1e-13));
        assert_eq!(value(&found, "correlation", "correlation_length"), None);
        assert!(found.remark.unwrap().contains("does not fall"));
    }
}

#[test]
fn a_fan_of_axes_has_no_order_and_random_ones_as_much_as_their_number_leaves() {
    let fan = state(square(10, ROD, |k| lying(PI * k as f64 / 100.0)), None);
    assert_near(value(&of("nematic", &fan, true), "nematic", "nematic_order"), 0.0, 1e-14);
    let three = [DQuat::IDENTITY, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2)];
    let three = state(bodies(three.map(|q| (ROD, DVec3::ZERO, q))), None);
    assert_near(value(&of("nematic", &three, false), "nematic", "nematic_order"), 0.0, 1e-14);
    // In the plane <S^2> = 1/N: the sum is a random walk of N unit steps.
    let squares: f64 = (0..100)
        .map(|seed| {
            value(&of("nematic", &random_axes(400, true, seed), true), "nematic", "nematic_order").unwrap().powi(2)
        })
        .sum();
    assert!((squares / 100.0 * 400.0 - 1.0).abs() < 0.4, "{squares}");
    // In space it falls likewise.
    let order =
        |count| value(&of("nematic", &random_axes(count, false, 1), false), "nematic", "nematic_order").unwrap();
    assert!(order(100) < 3.0 / 10.0 && order(10_000) < 3.0 / 100.0 && order(10_000) > 0.1 / 100.0);
}

#[test]
fn local_order_is_that_of_the_stated_neighbourhood() {
    // Two rods at right angles within reach of each other, two parallel ones farther off, and a lone one.
    let x = [0.0, 1.0, 10.0, 11.0, 30.0];
    let angle = [0.0, FRAC_PI_2, 0.4, 0.4, 0.1];
    let state = state(bodies((0..5).map(|k| (ROD, DVec3::X * x[k], lying(angle[k])))), None);
    let settings = Settings { neighbourhood: Some(1.0), ..Settings::default() };
    let found = of_settings("nematic", &state, true, &settings).unwrap();
    assert_near(value(&found, "nematic", "nematic_local"), 0.5, 1e-14);
    assert_near(value(&found, "nematic", "nematic_local_neighbours"), 0.8, 1e-15);
    let settings = Settings { neighbourhood: Some(0.5), ..Settings::default() };
    let found = of_settings("nematic", &state, true, &settings).unwrap();
    assert_eq!(value(&found, "nematic", "nematic_local"), None);
    assert!(found.remark.is_some());
}

#[test]
fn a_neighbourhood_of_too_many_is_left_out() {
    let crowd = state(bodies((0..20_000).map(|k| (ROD, DVec3::X * k as f64, lying(0.0)))), None);
    let settings = Settings { neighbourhood: Some(1e9), ..Settings::default() };
    let found = of_settings("nematic", &crowd, true, &settings).unwrap();
    assert_eq!(value(&found, "nematic", "nematic_local"), None);
    assert!(found.remark.unwrap().contains("too many pairs"));
}

#[test]
fn the_correlation_of_a_twisted_row_is_that_of_its_twist() {
    let twist = 0.02;
    let row = |k: usize| (ROD, DVec3::X * k as f64, lying(twist * k as f64));
    let state = state(bodies((0..400).map(row)), None);
    for (planar, expected) in
        [(true, (1.0 / E).acos() / (2.0 * twist)), (false, ((2.0 / E + 1.0) / 3.0).sqrt().acos() / twist)]
    {
        let found = of("correlation", &state, planar);
        // No pair is in the first bin; the last holds the two largest distances.
        assert_eq!(found.rows.len(), 398);
        for row in &found.rows[..397] {
            let [r, c] = [row[0].unwrap(), row[1].unwrap()];
            let analytic = if planar { (2.0 * twist * r).cos() } else { 1.5 * (twist * r).cos().powi(2) - 0.5 };
            assert!((c - analytic).abs() < 1e-12 && (r - r.round()).abs() < 1e-12, "{r}: {c} {analytic}");
        }
        assert_near(value(&found, "correlation", "correlation_pairs"), 400.0 * 399.0 / 2.0, 0.0);
        // Linear between whole distances: the arc's rise over a chord of 1 is at most its second derivative over 8.
        assert_near(value(&found, "correlation", "correlation_length"), expected, 0.01);
        // With sampling, each distance has the same mean; the seed determines which and how many pairs.
        let sampled = |seed| {
            let settings = Settings { correlation_pairs: 4000, seed, ..Settings::default() };
            of_settings("correlation", &state, planar, &settings).unwrap()
        };
        let (one, other) = (sampled(1), sampled(2));
        assert_eq!(value(&one, "correlation", "correlation_references"), Some(10.0));
        assert_eq!(value(&one, "correlation", "correlation_pairs"), Some(10.0 * 399.0));
        assert_near(value(&one, "correlation", "correlation_length"), expected, 0.01);
        assert!(one.remark.as_ref().unwrap().contains("10 bodies of 400, selected by seed 1"));
        assert_eq!(one, sampled(1));
        assert_ne!(one.rows, other.rows);
    }
}

#[test]
fn microdomains_end_where_the_angle_is_too_large() {
    // Rods tip to tip around a bend: turned by 2, 2, 5 and 2 degrees from one to the next, each end at the last one's.
    let mut angle = 0.0_f64;
    let mut tip = DVec3::ZERO;
    let mut placed = Vec::new();
    for turn in [0.0, 2.0, 2.0, 5.0, 2.0] {
        angle += f64::to_radians(turn);
        let direction = DVec3::new(angle.cos(), angle.sin(), 0.0);
        placed.push((ROD, tip + 1.0 * direction, lying(angle)));
        // The next cap's centre is one diameter on.
        tip += 3.0 * direction;
    }
    placed.push((BALL, DVec3::Y * 50.0, DQuat::IDENTITY));
    let chain = state(bodies(placed), None);
    let domains = |degrees: f64| {
        let settings = Settings { domain_angle_degrees: degrees, cutoff: Some(0.01), ..Settings::default() };
        of_settings("microdomains", &chain, true, &settings).unwrap()
    };
    let found = domains(3.0);
    let rod = 2.0 + 0.25 * PI;
    for (column, expected) in [
        ("domains", 2.0),
        ("domain_mean", 2.5),
        ("domain_largest", 3.0),
        ("domain_volume", 2.5 * rod),
        ("domain_volume_weighted", (9.0 + 4.0) / 5.0 * rod),
    ] {
        assert_near(value(&found, "microdomains", column), expected, 1e-12);
    }
    assert_eq!(found.rows, [[Some(2.0), Some(1.0)], [Some(3.0), Some(1.0)]]);
    assert_eq!(value(&domains(1.0), "microdomains", "domains"), Some(5.0));
    assert_eq!(value(&domains(6.0), "microdomains", "domains"), Some(1.0));
}

#[test]
fn bodies_without_an_axis_have_no_order() {
    let balls = state(square(3, BALL, |_| DQuat::IDENTITY), None);
    for name in ["nematic", "correlation", "microdomains"] {
        assert!(of_settings(name, &balls, true, &Settings::default()).is_err(), "{name}");
    }
    // A rod among them has an axis, but no partner to compare with.
    let mut mixed = square(3, BALL, |_| DQuat::IDENTITY);
    mixed.push(Placed { shape: ROD, position: DVec3::X * 20.0, orientation: lying(0.0) }, NO_GROUP);
    let mixed = state(mixed, None);
    assert_eq!(value(&of("nematic", &mixed, true), "nematic", "nematic_axes"), Some(1.0));
    assert!(of_settings("correlation", &mixed, true, &Settings::default()).is_err());
    assert_eq!(of("length", &mixed, true).values, [1.0, 3.0, 0.0, 3.0, 3.0].map(Some));
}
