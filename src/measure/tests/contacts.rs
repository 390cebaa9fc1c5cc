//! Stress, contacts, force chains and dissipation.

use super::*;

#[test]
fn the_stress_of_one_contact_is_its_virial() {
    // Parallel rods that touch along their sides, one shifted; the upper one pushed down with 4.
    let pair = bodies([(ROD, DVec3::ZERO, lying(0.0)), (ROD, DVec3::new(0.3, 1.0, 0.0), lying(0.0))]);
    let found = of("stress", &state(pair, Some(&[([0, 1], 4.0)])), true);
    let area = 2.0 * (2.0 + 0.25 * PI);
    for (column, expected) in [
        ("stress_yy", 4.0 / area),
        ("stress_xy", 0.5 * 4.0 * 0.3 / area),
        ("stress_xx", 0.0),
        ("pressure", 2.0 / area),
        ("shear", (2.0_f64.powi(2) + 0.6_f64.powi(2)).sqrt() / area),
        ("force_mean", 4.0),
    ] {
        assert_near(value(&found, "stress", column), expected, 1e-14);
    }
    assert_eq!(value(&found, "stress", "stress_zz"), None);
    // The bodies' own virials add up to the whole.
    let rings: f64 = found.rows.iter().enumerate().map(|(k, row)| row[1].unwrap() * PI * (2 * k + 1) as f64).sum();
    assert!((rings - 2.0).abs() < 1e-13, "{rings}");
    // Two balls in space, along a diagonal.
    let direction = DVec3::new(2.0, -1.0, 2.0) / 3.0;
    let balls = bodies([(BALL, DVec3::ZERO, DQuat::IDENTITY), (BALL, direction, DQuat::IDENTITY)]);
    let found = of("stress", &state(balls, Some(&[([0, 1], 3.0)])), false);
    let volume = 2.0 * PI / 6.0;
    assert_near(value(&found, "stress", "stress_xz"), 3.0 * 4.0 / 9.0 / volume, 1e-14);
    assert_near(value(&found, "stress", "stress_yy"), 3.0 / 9.0 / volume, 1e-14);
    assert_near(value(&found, "stress", "pressure"), 1.0 / volume, 1e-14);
    assert_near(value(&found, "stress", "shear"), 1.5 / volume, 1e-14);
}

#[test]
fn contacts_chains_and_their_absence() {
    let row = || bodies((0..5).map(|k| (BALL, DVec3::X * if k < 4 { k as f64 } else { 9.0 }, DQuat::IDENTITY)));
    let forces = [([0, 1], 1.0), ([1, 2], 4.0), ([2, 3], 0.0)];
    let pushed = state(row(), Some(&forces));
    let found = of("contacts", &pushed, true);
    let expected = [5e-4 * 2.0, 3.0, 1.2, 1.0, 2.0, 0.8, 2.0];
    assert_eq!(found.values, expected.map(Some));
    let histogram = [[0.0, 1.0, 2.0], [1.0, 2.0, 2.0], [2.0, 2.0, 1.0]];
    assert_eq!(found.rows, histogram.map(|row| row.map(Some).to_vec()));
    let chains = of("force_chains", &pushed, true);
    assert_eq!(chains.values, [2.5, 1.0, 0.5, 1.0, 2.0, 2.0].map(Some));
    assert_eq!(chains.rows, [[Some(2.0), Some(1.0)]]);
    // Without forces the measures of forces are undefined; those of touching are defined.
    let still = state(row(), None);
    let found = of("contacts", &still, true);
    assert_eq!((found.values[1], &found.values[4..]), (Some(3.0), &[None; 3][..]));
    for name in ["stress", "force_chains"] {
        let LeftOut(reason) = of_settings(name, &still, true, &Settings::default()).unwrap_err();
        assert!(reason.contains("only a checkpoint"), "{reason}");
    }
    let mut sub_spheres = pushed;
    sub_spheres.warm.as_mut().unwrap()[1].feature = 3;
    let LeftOut(reason) = of_settings("stress", &sub_spheres, true, &Settings::default()).unwrap_err();
    assert!(reason.contains("sub-spheres"), "{reason}");
}

#[test]
fn dissipation_is_the_power_of_the_drag() {
    let mut one = bodies([(ROD, DVec3::ZERO, lying(0.0))]);
    one.velocity[0] = DVec3::new(3.0, 4.0, 0.0);
    one.angular_velocity[0] = DVec3::Z * 2.0;
    let mut state = state(one, None);
    assert_near(of("dissipation", &state, true).values[0], 2.0 * (3.0 * 25.0 + 27.0 * 4.0 / 12.0), 1e-12);
    state.step = 0;
    assert!(of_settings("dissipation", &state, true, &Settings::default()).is_err());
}

#[test]
fn a_lattice_of_equal_forces_has_the_pressure_of_its_cell_and_columns_are_chains() {
    let side = 11_u32;
    let right = (0..side * side).filter(|k| k % side + 1 < side).map(|k| [k, k + 1]);
    let up = (0..side * (side - 1)).map(|k| [k, k + side]);
    let lattice = |beside: f64, above: f64| {
        let mut forces: Vec<_> = right.clone().map(|pair| (pair, beside)).collect();
        forces.extend(up.clone().map(|pair| (pair, above)));
        state(square(side as usize, BALL, |_| DQuat::IDENTITY), Some(&forces))
    };
    // A cell of side 1 with a force of 3 across each of its sides.
    let settings = Settings { bin: Some(1.0), ..Settings::default() };
    let even = of_settings("stress", &lattice(3.0, 3.0), true, &settings).unwrap();
    for row in &even.rows[..5] {
        assert!((row[2].unwrap() - 3.0 / (0.25 * PI)).abs() < 1e-12, "{row:?}");
    }
    let contacts = f64::from(2 * side * (side - 1));
    let area = f64::from(side * side) * 0.25 * PI;
    assert_near(value(&even, "stress", "pressure"), 3.0 * contacts / (2.0 * area), 1e-12);
    assert_near(value(&even, "stress", "shear"), 0.0, 1e-12);
    // No contact exceeds the mean of equal ones; strong columns that weak rows connect are one chain each.
    assert_eq!(value(&of("force_chains", &lattice(3.0, 3.0), true), "force_chains", "chains"), Some(0.0));
    let columns = of("force_chains", &lattice(1.0, 5.0), true);
    assert_eq!(columns.values, [3.0, contacts / 2.0, 0.5, 11.0, 11.0, 11.0].map(Some));
    assert_eq!(columns.rows, [[Some(11.0), Some(11.0)]]);
}

#[test]
fn friction_is_measured_by_what_contacts_may_have() {
    let mut touching = state(
        bodies((0..3).map(|k| (BALL, DVec3::X * f64::from(k), DQuat::IDENTITY))),
        Some(&[([0, 1], 4.0), ([1, 2], 2.0)]),
    );
    let warm = touching.warm.as_mut().unwrap();
    (warm[0].tangent, warm[1].tangent) = (DVec3::Y, -DVec3::Z);
    let rough = crate::constraint::friction::Friction::of_all(0.5);
    let friction = crate::constraint::friction::Coefficients::new(&rough, &[], &[], 0.0);
    let frame = Frame { friction: Some(friction), ..frame(false) };
    let settings = Settings::default();
    let view = View::new(&touching, &frame, &settings);
    let found = select(&["friction".into()]).unwrap()[0].of(&view).unwrap();
    // One uses 1 of 2, the other 1 of 1.
    assert_eq!(found.values, [2.0, 0.75, 0.5, 1.0, 1.0].map(Some));
    // The stress has the whole force: the sum of f_z l_x is -1, its symmetric part half of it.
    let found = select(&["stress".into()]).unwrap()[0].of(&view).unwrap();
    let volume = 3.0 * PI / 6.0;
    assert_near(value(&found, "stress", "stress_xz"), -0.5 / volume, 1e-14);
    assert_near(value(&found, "stress", "stress_xy"), 0.5 / volume, 1e-14);
    let LeftOut(reason) = of_settings("friction", &touching, false, &Settings::default()).unwrap_err();
    assert!(reason.contains("no friction"), "{reason}");
}
