//! The table of measures: named, documented, with a value or none for every column.

use super::*;

#[test]
fn a_scene_may_name_every_measure() {
    assert_eq!(ALL.map(|measure| measure.name()), crate::scene::MEASURES);
}

#[test]
fn the_table_is_sound_and_documented() {
    let page = include_str!("../../../docs/measures.md");
    let mut names = BTreeSet::new();
    for measure in ALL {
        assert!(page.contains(&format!("## `{}`", measure.name())), "{}", measure.name());
        for column in measure.columns() {
            assert!(names.insert(column.name), "{}", column.name);
            assert!(page.contains(&format!("`{}`", column.name)), "{}", column.name);
        }
        for column in measure.profile().map_or(&[][..], |profile| profile.columns) {
            assert!(page.contains(&format!("`{}`", column.name)), "{}", column.name);
        }
        let columns: Vec<_> = measure.columns().iter().map(|column| column.name).collect();
        assert!(measure.about().plots.iter().flat_map(|plot| plot.iter()).all(|name| columns.contains(name)));
        assert!(measure.profile().is_none_or(|profile| profile.drawn < profile.columns.len()));
    }
    assert!(matches!(select(&["nothing".into()]), Err(MeasureError::Unknown { .. })));
}

#[test]
fn every_state_gives_a_number_or_none_for_every_column() {
    let mut all_shapes = bodies([
        (ROD, DVec3::ZERO, lying(0.1)),
        (BALL, DVec3::X * 1.5, DQuat::IDENTITY),
        (Shape::Ellipsoid { radii: [1.0, 2.0, 0.5] }, DVec3::Y * 3.0, DQuat::IDENTITY),
        (Shape::Torus { major_radius: 2.0, minor_radius: 0.2 }, DVec3::X * 9.0, DQuat::IDENTITY),
    ]);
    all_shapes.velocity[0] = DVec3::X;
    for (bodies, forces) in [(Bodies::default(), None), (Bodies::default(), Some(&[][..])), (all_shapes, Some(&[][..]))]
    {
        let state = state(bodies, forces);
        for planar in [true, false] {
            let (frame, settings) = (frame(planar), Settings::default());
            let view = View::new(&state, &frame, &settings);
            for measure in ALL {
                let Ok(found) = measure.of(&view) else { continue };
                let width = measure.profile().map_or(0, |profile| profile.columns.len());
                assert_eq!(found.values.len(), measure.columns().len(), "{}", measure.name());
                assert!(found.rows.iter().all(|row| row.len() == width), "{}", measure.name());
                let finite = |cell: &Cell| cell.is_none_or(f64::is_finite);
                assert!(found.values.iter().chain(found.rows.iter().flatten()).all(finite), "{}", measure.name());
            }
        }
    }
}

#[test]
fn numbers_that_are_not_are_refused_with_their_place() {
    let mut bad = bodies([(BALL, DVec3::ZERO, DQuat::IDENTITY), (BALL, DVec3::X * f64::NAN, DQuat::IDENTITY)]);
    let states = States::single("mine", state(bad.clone(), None));
    let refused = |states: &States| {
        collect::measure_in(frame(true), states, 0, &ALL, &Settings::default(), &mut |_, _| true).err().unwrap()
    };
    assert_eq!(refused(&states).to_string(), "mine: body 1: its position is not finite");
    bad.position[1] = DVec3::X;
    bad.orientation[0] = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    assert!(refused(&States::single("mine", state(bad.clone(), None))).to_string().contains("body 0: its orientation"));
    bad.shape[0] = Shape::Spherocylinder { diameter: 1.0, length: 0.5 };
    bad.orientation[0] = DQuat::IDENTITY;
    assert!(refused(&States::single("mine", state(bad, None))).to_string().contains("body 0: its shape cannot be"));
    let good = States::single("mine", state(square(2, BALL, |_| DQuat::IDENTITY), None));
    let stopped = collect::measure_in(frame(true), &good, 0, &ALL, &Settings::default(), &mut |_, _| false);
    assert!(matches!(stopped, Err(MeasureError::Stopped { done: 0, all: 1 })));
}
