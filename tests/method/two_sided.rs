//! What pushes touches at the end of a step: rows in line between closing walls against closed forms, growth chambers
//! in which nobody is thrown, and what contact may not do.

use glam::DVec3;
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::freedom::PLANAR;
use relcp::internals::step::Verbs;
use relcp::step::{Fault, State};
use relcp::{Scene, Simulation, StepReport};

const TOLERANCE: f64 = 1e-5;

fn scene(text: &str) -> Scene {
    Scene::parse(text, "scene").unwrap()
}

fn run(scene: Scene) -> (Simulation, Vec<StepReport>) {
    let (mut simulation, mut reports) = (Simulation::new(scene).unwrap(), Vec::new());
    while !simulation.done() {
        reports.push(simulation.step().unwrap());
    }
    (simulation, reports)
}

/// Bodies of diameter `thick` and length 2 end to end, `aside` out of line by turns, between walls of which one closes
/// by 1.
fn squeezed(shape: &str, bodies: usize, aside: f64, dt: f64, planar: bool) -> Scene {
    let place = |i: usize| {
        let x = 2.0 * i as f64 - (bodies as f64 - 1.0);
        let y = if i.is_multiple_of(2) { -aside } else { aside };
        format!(r#"{{ "shape": {shape}, "position": [{x}, {y}, 0], "axis": [1, 0, 0] }}"#)
    };
    let list: Vec<String> = (0..bodies).map(place).collect();
    let end = -(bodies as f64);
    scene(&format!(
        r#"{{ "name": "squeezed", "planar": {planar}, "time": {{ "dt": {dt}, "end": 1 }},
            "walls": [ {{ "half_space": {{ "normal": [1, 0, 0], "offset": {end} }} }},
                {{ "half_space": {{ "normal": [-1, 0, 0], "offset": {end}, "motion": {{ "velocity": [-1, 0, 0] }} }} }} ],
            "bodies": [ {} ] }}"#,
        list.join(", ")
    ))
}

const BALL: &str = r#"{ "sphere": { "radius": 1 } }"#;

fn largest(reports: &[StepReport], of: impl Fn(&StepReport) -> f64) -> f64 {
    reports.iter().map(of).fold(0.0, f64::max)
}

/// One wall has closed by 1: the centres are 1 apart along x, and so the root of 3 across.
#[test]
fn two_balls_in_line_are_pressed_aside_as_far_as_they_must_and_no_farther() {
    for planar in [true, false] {
        for dt in [0.02, 0.002] {
            for aside in [1e-2, 2.5e-4, 5e-7, 0.0] {
                let (simulation, reports) = run(squeezed(BALL, 2, aside, dt, planar));
                let apart =
                    simulation.state().unwrap().bodies.position[1] - simulation.state().unwrap().bodies.position[0];
                let across = apart.y.hypot(apart.z);
                assert!((across - 3f64.sqrt()).abs() < 2e-4, "{planar} {dt} {aside}: {apart}");
                assert!(largest(&reports, |r| r.largest_move) < 0.25, "{planar} {dt} {aside}");
                assert!(largest(&reports, |r| r.largest_push_gap) < 0.04, "{planar} {dt} {aside}");
            }
        }
    }
}

/// Where only contact moves balls, a step makes half of the sum of the squares of their moves least. Each round of
/// loosening keeps or lowers it, so that a step comes to less than with the rows of its start alone.
#[test]
fn loosening_lowers_the_objective() {
    let moved_by = |rows: &str, start: &Simulation, dt: f64, list: &str| {
        let text = format!(
            r#"{{ "name": "crowd", "planar": true, "time": {{ "dt": {dt}, "end": {dt} }}, "contact": {{ "rows": "{rows}" }},
                "walls": [ {{ "half_space": {{ "normal": [0, 1, 0], "offset": -3 }} }},
                    {{ "half_space": {{ "normal": [1, 0, 0], "offset": -9 }} }},
                    {{ "half_space": {{ "normal": [-1, 0, 0], "offset": -9, "motion": {{ "velocity": [-1, 0, 0] }} }} }} ],
                "bodies": [ {list} ] }}"#
        );
        let (simulation, reports) = run(scene(&text));
        let before = &start.state().unwrap().bodies.position;
        let after = &simulation.state().unwrap().bodies.position;
        let objective = before.iter().zip(after).map(|(p, q)| 0.5 * p.distance_squared(*q)).sum::<f64>();
        (objective, reports[0])
    };
    let (mut loosened, mut lower) = (0, 0);
    for seed in 0..60_u32 {
        // A row of nine balls between the walls, out of line by up to 0.03, that touch: the wall comes by 0.05 to 0.3.
        let uneven = |i: u32| 0.03 * f64::from((seed * 37 + i * 101 + 13) * (i + 7) % 199) / 199.0;
        let ball = |i: u32| {
            let (x, y) = (2.0 * f64::from(i) - 8.0, uneven(i));
            format!(r#"{{ "shape": {{ "sphere": {{ "radius": 1 }} }}, "position": [{x}, {y}, 0] }}"#)
        };
        let list: Vec<String> = (0..9).map(ball).collect();
        let list = list.join(", ");
        let dt = 0.05 * f64::from(1 + seed % 6);
        let start = Simulation::new(scene(&format!(
            r#"{{ "name": "row", "time": {{ "dt": 1, "end": 1 }}, "planar": true, "bodies": [ {list} ] }}"#
        )))
        .unwrap();
        let [(both, report), (one, _)] = ["auto", "paper"].map(|rows| moved_by(rows, &start, dt, &list));
        if report.loosened > 0 && report.pieces == 1 {
            loosened += 1;
            lower += u32::from(both < 0.99 * one);
        }
        assert!(both <= one * (1.0 + 1e-6), "{seed}: {both:e} and {one:e}");
    }
    println!("{loosened} of 60 steps loosened, {lower} of them lower by more than a hundredth");
    assert!(loosened >= 20 && lower >= 20, "{loosened} {lower}");
}

/// Two pairs of balls between the same walls, far from each other: one exactly in line, whose rows are rebuilt, one
/// that slides past each other by more than rebuilt rows may and less than others may.
#[test]
fn a_pair_whose_rows_are_rebuilt_does_not_loosen_those_of_a_crowd_elsewhere() {
    let loosened = |pairs: &[f64]| {
        let ball =
            |x: f64, y: f64| format!(r#"{{ "shape": {{ "sphere": {{ "radius": 1 }} }}, "position": [{x}, {y}, 0] }}"#);
        let of_pair = |(i, aside): (usize, &f64)| {
            let y = 20.0 * i as f64;
            [ball(-1.0, y - aside), ball(1.0, y + aside)]
        };
        let list: Vec<String> = pairs.iter().enumerate().flat_map(of_pair).collect();
        let text = format!(
            r#"{{ "name": "pairs", "planar": true, "time": {{ "dt": 0.02, "end": 0.02 }},
                "walls": [ {{ "half_space": {{ "normal": [1, 0, 0], "offset": -2 }} }},
                    {{ "half_space": {{ "normal": [-1, 0, 0], "offset": -2, "motion": {{ "velocity": [-1, 0, 0] }} }} }} ],
                "bodies": [ {} ] }}"#,
            list.join(", ")
        );
        let (_, reports) = run(scene(&text));
        (reports[0].loosened, reports[0].largest_push_gap / 2.0)
    };
    let (of_slide, gap) = loosened(&[0.05]);
    assert!(of_slide == 0 && gap > 2e-3 && gap < 0.02, "{of_slide} {gap}");
    let (in_line, _) = loosened(&[0.0]);
    let (both, kept) = loosened(&[0.0, 0.05]);
    assert!(in_line > 0 && both == in_line && (kept - gap).abs() < 1e-4, "{in_line} {both} {kept} {gap}");
}

#[test]
fn rows_of_bodies_buckle_and_none_is_thrown() {
    let rod = r#"{ "spherocylinder": { "diameter": 0.6, "length": 2 } }"#;
    let ellipsoid = r#"{ "ellipsoid": { "radii": [0.3, 0.3, 1] } }"#;
    for (shape, bodies) in [(BALL, 3), (BALL, 8), (BALL, 20), (rod, 2), (rod, 5), (ellipsoid, 2), (ellipsoid, 5)] {
        for aside in [1e-3, 0.0] {
            let planar = shape != ellipsoid;
            let (_, reports) = run(squeezed(shape, bodies, aside, 0.01, planar));
            assert!(largest(&reports, |r| r.max_overlap) <= TOLERANCE, "{shape} {bodies} {aside}");
            assert!(largest(&reports, |r| r.largest_move) < 0.5, "{shape} {bodies} {aside}");
        }
    }
}

#[test]
fn what_is_drawn_is_the_same_on_any_number_of_threads_and_after_a_resumption() {
    let scene = || squeezed(BALL, 8, 0.0, 0.01, true);
    let end = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(scene()).0.state().unwrap().clone())
    };
    let whole = end(1);
    assert_eq!(end(3), whole);
    let mut first = Simulation::new(scene()).unwrap();
    let report = first.step().unwrap();
    assert!(report.tilts > 0, "{report:?}");
    let state = first.state().unwrap().clone();
    let mut resumed = Simulation::builder(scene()).resume(state).build().unwrap();
    while !resumed.done() {
        resumed.step().unwrap();
    }
    assert_eq!(resumed.state().unwrap(), &whole);
}

/// A chamber that is open above: cells leave it one after the other.
#[test]
fn cells_of_a_chamber_with_one_open_end_are_pushed_out_not_thrown() {
    for (seed, width) in [(1, 10.7), (2, 10.7), (3, 6.0)] {
        let (_, reports) = run(scene(&format!(
            r#"{{ "name": "trap", "seed": {seed}, "planar": true, "time": {{ "dt": 0.002, "end": 6.5 }},
                "walls": [ {{ "channel": {{ "normal": [1, 0, 0], "center": [0, 0, 0], "width": {width} }} }},
                    {{ "half_space": {{ "normal": [0, 1, 0], "offset": 0 }} }} ],
                "growth": {{ "rate": 1, "rate_noise": 0.1, "rule": "adder", "added_length": 2, "added_length_noise": 0.2,
                    "reorientation_degrees": 3 }},
                "removal": [ {{ "outside": {{ "half_space": {{ "normal": [0, -1, 0], "offset": -10 }} }} }} ],
                "bodies": [ {{ "shape": {{ "spherocylinder": {{ "diameter": 1, "length": 2 }} }}, "position": [0, 3, 0],
                    "angle": 40 }} ] }}"#
        )));
        assert!(reports.iter().any(|r| r.removed > 0), "it overflows");
        assert!(reports.iter().all(|r| r.removed <= 4), "{:?}", reports.iter().map(|r| r.removed).max());
        // Of ten such chambers of width 6, five move a cell by 0.5 to 0.78 in a step, in which a row buckles.
        assert!(largest(&reports, |r| r.largest_move) < 0.8, "{seed}: {}", largest(&reports, |r| r.largest_move));
        assert!(largest(&reports, |r| r.max_overlap) <= TOLERANCE);
    }
}

/// At t = 4.04 the cells of this chamber are about to buckle, and the shortest piece leads to a side that throws them:
/// the run stopped with "no room" under an open top.
#[test]
fn a_chamber_that_is_about_to_buckle_neither_throws_nor_has_no_room() {
    let (_, reports) = run(scene(
        r#"{ "name": "chamber", "seed": 207763144, "planar": true,
            "time": { "dt": 0.004578904382401994, "end": 4.2 },
            "walls": [ { "channel": { "normal": [1, 0, 0], "center": [0, 0, 0], "width": 7 } },
                { "half_space": { "normal": [0.006346833309423444, 0.9999798586506342, 0], "offset": 0 } } ],
            "growth": { "rate": 1, "rate_noise": 0.07694790018357499, "rule": "adder", "added_length": 2,
                "added_length_noise": 0.161543158175856, "reorientation_degrees": 3.4017837498016923 },
            "removal": [ { "outside": { "half_space": { "normal": [0, -1, 0], "offset": -11.608318819706266 } } } ],
            "bodies": [ { "shape": { "spherocylinder": { "diameter": 1, "length": 2 } },
                "position": [0.8958874639484082, 1.4564147792515834, 0],
                "orientation": [0.06912743827579329, -0.7037196865779913, 0.06912743827579329, 0.7037196865779914] } ] }"#,
    ));
    assert!(largest(&reports, |r| r.largest_move) < 1.0, "{}", largest(&reports, |r| r.largest_move));
    assert!(reports.iter().all(|r| r.removed <= 4));
}

/// Two discs 1000:1 that fall on each other and on a floor once gained 90 of energy in one step.
#[test]
fn thin_discs_gain_no_energy_by_contact() {
    let (_, reports) = run(scene(
        r#"{ "name": "discs", "dynamics": { "inertial": { "density": 1 } }, "time": { "dt": 0.005, "end": 1.5 },
            "forces": [ { "gravity": { "acceleration": [0, 0, -5] } } ],
            "walls": [ { "half_space": { "normal": [0, 0, 1], "offset": 0 } } ],
            "bodies": [
                { "shape": { "ellipsoid": { "radii": [2, 2, 0.002] } }, "position": [0.218, -0.016, 2.5],
                  "orientation": [0.6023, 0.1822, -0.0545, 0.7753] },
                { "shape": { "ellipsoid": { "radii": [2, 2, 0.002] } }, "position": [0.007, 0.183, 6.7],
                  "orientation": [0.0186, -0.2339, 0.7068, -0.6674], "velocity": [0, 0, -2] } ] }"#,
    ));
    assert!(reports.iter().all(|r| r.contact_energy < 1e-3), "{}", largest(&reports, |r| r.contact_energy));
    assert!(reports.iter().any(|r| r.contact_energy < 0.0), "they touch");
}

#[test]
fn contact_does_not_spin_rods_about_their_own_axes() {
    let (simulation, reports) = run(scene(
        r#"{ "name": "rods", "dynamics": { "inertial": { "density": 1 } }, "time": { "dt": 0.01, "end": 3 },
            "bodies": [
                { "shape": { "spherocylinder": { "diameter": 0.1, "length": 2 } }, "position": [0, 0, 0], "axis": [1, 0, 0],
                  "velocity": [0, 0, 1] },
                { "shape": { "spherocylinder": { "diameter": 0.1, "length": 2 } }, "position": [0.43, 0.43, 0.8],
                  "axis": [-0.25, 0.42, 0.23] } ] }"#,
    ));
    assert!(reports.iter().any(|r| r.recursions > 0), "no row was made at a trial");
    assert!(largest(&reports, |r| r.axial_spin) < 1e-14, "{:e}", largest(&reports, |r| r.axial_spin));
    let bodies = &simulation.state().unwrap().bodies;
    for (angular, orientation) in bodies.angular_velocity.iter().zip(&bodies.orientation) {
        let spin = angular.dot(*orientation * glam::DVec3::Z);
        assert!(angular.length() > 0.01 && spin.abs() < 1e-6, "{spin:e} of {angular}");
    }
}

/// Its axis has turned by the angle whose cosine is the room over the length of its segment.
#[test]
fn a_rod_exactly_across_a_channel_turns_as_it_grows_and_is_not_without_room() {
    for dt in [0.01, 0.002] {
        let (simulation, reports) = run(scene(&format!(
            r#"{{ "name": "across", "planar": true, "time": {{ "dt": {dt}, "end": 0.4 }},
                "walls": [ {{ "channel": {{ "normal": [1, 0, 0], "center": [0, 0, 0], "width": 3.2 }} }} ],
                "growth": {{ "rate": 0.7, "rule": "adder", "added_length": 2 }},
                "bodies": [ {{ "shape": {{ "spherocylinder": {{ "diameter": 1, "length": 3 }} }}, "position": [0, 0, 0], "axis": [1, 0, 0] }} ] }}"#
        )));
        let bodies = &simulation.state().unwrap().bodies;
        let length = bodies.shape[0].growing_length().unwrap();
        let along = (bodies.orientation[0] * DVec3::Z).x.abs();
        assert!(length > 3.5, "{length}");
        assert!((along * (length - 1.0) - 2.2).abs() < 1e-4, "{dt}: {along} of {length}");
        assert!(largest(&reports, |r| r.largest_move) < 0.1, "{dt}");
    }
}

/// The cells of a row fill their channel from side to side and divide all at once: none of their daughters can turn.
#[test]
fn daughters_without_room_to_turn_turn_less_and_the_run_goes_on() {
    let cells: Vec<String> = (-3..4)
        .map(|k| {
            let x = 6.0 * f64::from(k);
            format!(
                r#"{{ "shape": {{ "spherocylinder": {{ "diameter": 1, "length": 5.9 }} }}, "position": [{x}, 0, 0], "axis": [1, 0, 0] }}"#
            )
        })
        .collect();
    let (simulation, reports) = run(scene(&format!(
        r#"{{ "name": "row", "planar": true, "seed": 3, "time": {{ "dt": 0.01, "end": 1.5 }},
            "walls": [ {{ "channel": {{ "normal": [0, 1, 0], "center": [0, 0, 0], "width": 1 }} }} ],
            "growth": {{ "rate": 1, "division_length": 6, "reorientation_degrees": 30 }},
            "bodies": [ {} ] }}"#,
        cells.join(", ")
    )));
    let state = simulation.state().unwrap();
    assert_eq!(state.bodies.len(), 56);
    assert!(reports.iter().any(|report| report.turned_less > 0));
    for (position, orientation) in state.bodies.position.iter().zip(&state.bodies.orientation) {
        let axis = *orientation * DVec3::Z;
        assert!(position.y.abs() < TOLERANCE && axis.y.abs() < TOLERANCE, "{position} {axis}");
    }
}

/// The closed form of a long chain that conjugate gradients solve slowly and the interior point takes over.
#[test]
fn a_line_of_cells_is_as_long_as_its_cells_and_its_centre_stays() {
    let (simulation, reports) = run(scene(
        r#"{ "name": "line", "planar": true, "time": { "dt": 0.05, "end": 6.6 },
            "growth": { "rate": 1, "division_length": 4 },
            "generate": [ { "founder": { "diameter": 0.5, "length": 2 } } ] }"#,
    ));
    assert!(reports.iter().map(|report| report.fallbacks).sum::<u32>() > 0);
    let bodies = &simulation.state().unwrap().bodies;
    let lengths: Vec<f64> = bodies.shape.iter().map(|shape| shape.growing_length().unwrap()).collect();
    let end = |sign: f64| {
        let ends = bodies.position.iter().zip(&lengths).map(|(position, length)| sign * position.x + 0.5 * length);
        ends.fold(f64::NEG_INFINITY, f64::max)
    };
    let (extent, sum) = (end(1.0) + end(-1.0), lengths.iter().sum::<f64>());
    assert_eq!(lengths.len(), 512);
    assert!((extent - sum).abs() < TOLERANCE, "{extent} {sum}");
    let centre = bodies.position.iter().sum::<DVec3>() / lengths.len() as f64;
    assert!(centre.length() < 1e-9, "{centre}");
}

/// A wall at an angle of a sine of 0.1 to the floor closes on a ball of diameter 1 between them, which moves along the
/// floor ten times as far as the wall closes: in one step at most by half of its diameter.
#[test]
fn a_ball_that_a_closing_wedge_throws_is_seen_at_a_trial_as_at_the_end() {
    let (sine, dt) = (0.1, 0.1);
    let cosine = f64::sqrt(1.0 - sine * sine);
    for (move_, thrown) in [(0.3, false), (0.49, false), (0.51, true), (2.0, true)] {
        let velocity = [sine, -cosine].map(|n| n * move_ * sine / dt);
        let scene = scene(&format!(
            r#"{{ "name": "wedge", "planar": true, "time": {{ "dt": {dt}, "end": {dt} }},
            "walls": [ {{ "half_space": {{ "normal": [0, 1, 0], "offset": 0 }} }},
                {{ "half_space": {{ "normal": [{sine}, {}, 0], "offset": {},
                    "motion": {{ "velocity": [{}, {}, 0] }} }} }} ],
            "bodies": [ {{ "shape": {{ "sphere": {{ "radius": 0.5 }} }}, "position": [0, 0.5, 0] }} ] }}"#,
            -cosine,
            -0.5 * cosine - 0.5,
            velocity[0],
            velocity[1]
        ));
        let state = State { next_id: 1, bodies: scene.build().unwrap(), ..State::default() };
        let mut backend = Cpu::<PLANAR>::new(&scene.model(), state).unwrap();
        backend.begin().unwrap();
        backend.append_near().unwrap();
        backend.solve(1e-9).unwrap();
        backend.trial(TOLERANCE).unwrap();
        let seen = Verbs::two_sided(&mut backend).unwrap().moves_too_far();
        assert_eq!((seen, backend.effect(0.02).unwrap().thrown > 0), (thrown, thrown), "{move_}");
        let (simulation, reports) = run(scene);
        assert_eq!(reports[0].pieces > 1, thrown, "{move_}");
        let x = simulation.state().unwrap().bodies.position[0].x;
        assert!((x - move_).abs() < 2.0 * TOLERANCE / sine, "{x} {move_}");
    }
}

/// Its contacts are rigid to first order, for which the run ended with "no room" though space is open: no row shows a
/// motion along which they open to second order. Some steps find it in pieces, some of these after a small random move.
#[test]
fn cells_in_a_narrowing_chamber_find_the_way_that_no_constraint_shows() {
    let mut shaken = 0;
    for part in [0.5, 0.7, 0.9, 1.0, 1.2, 1.4, 1.7, 2.0, 3.9, 4.0, 4.4, 4.5] {
        let mut scene = Scene::read("tests/data/narrowing-chamber.json").unwrap();
        scene.time.dt *= part;
        let mut simulation = Simulation::new(scene).unwrap();
        let reports: Vec<StepReport> = (0..2).map(|_| simulation.step().unwrap()).collect();
        shaken += reports.iter().map(|report| report.shaken).sum::<u32>();
        assert!(largest(&reports, |r| r.max_overlap) <= TOLERANCE, "{part}");
        // That of a step in pieces is the sum of its pieces, and longer steps are of more.
        assert!(largest(&reports, |r| r.largest_move) < 0.6 + 0.1 * part, "{part}");
    }
    println!("{shaken} steps with a random move");
    assert!(shaken > 0);
}

/// Its last trial throws cells through each other, for which the run ended with "overlap".
#[test]
fn a_full_disc_has_no_room_where_a_tenth_of_the_step_has_none() {
    let end = |dt: f64| {
        let text = format!(
            r#"{{ "name": "disc", "seed": 1411559893, "planar": true, "time": {{ "dt": {dt}, "end": 8 }},
            "walls": [{{ "sphere": {{ "center": [0, 0, 0], "radius": 1.9007407138500574 }} }}],
            "growth": {{ "rate": 1.242456231626048, "division_length": 2.924216482846242, "division_length_noise": 0.1869371442330984,
                        "reorientation_degrees": 7.183316086532651, "rate_noise": 0.06373723548223915 }},
            "bodies": [{{ "shape": {{ "spherocylinder": {{ "diameter": 0.5, "length": 1.5634731525744427 }} }}, "position": [0, 0, 0],
                       "orientation": [0.7067774210816313, 0.021579551644983416, 0.7067774210816312, -0.02157955164498342] }}] }}"#
        );
        let mut simulation = Simulation::new(scene(&text)).unwrap();
        let fault = loop {
            match simulation.step() {
                Ok(_) => assert!(!simulation.done()),
                Err(fault) => break fault,
            }
        };
        (simulation.time(), fault)
    };
    let [(time, fault), (exact, _)] = [1.5250681818242576e-3, 1.5250681818242576e-4].map(end);
    assert!(matches!(fault, Fault::NoRoom { bodies: 8, .. }), "{fault}");
    assert!((time / exact - 1.0).abs() < 5e-3, "{time} {exact}");
}

/// Thin rods and rings that forces carry over many thicknesses in a step: the shortest piece has no solution, and the
/// trial that parts its bodies sent one 1e13 away.
#[test]
fn parting_what_a_piece_could_not_sends_no_body_away() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/crossed-rods-and-rings.json");
    let mut simulation = Simulation::new(scene(&std::fs::read_to_string(path).unwrap())).unwrap();
    for _ in 0..30 {
        // That it finds no room, it may say.
        if let Err(fault) = simulation.step() {
            assert!(!matches!(fault, Fault::RunAway { .. }), "{fault}");
            break;
        }
        let position = &simulation.state().unwrap().bodies.position;
        let farthest = position.iter().map(|x| x.length()).fold(0.0, f64::max);
        assert!(farthest < 100.0, "{farthest}");
    }
}

/// Six thin discs face to face, a billionth out of line, between walls that close: the shortest pieces of a step gave
/// them speeds 30,000 times those of the walls, and the run went on without a word. Energy has no bound where walls
/// move.
#[test]
fn discs_in_line_between_closing_walls_do_not_fly_apart_without_a_word() {
    let scene = scene(include_str!("../data/discs-in-line.json"));
    let (longest, dt) = (2.0 * 0.7247460153853724, scene.time.dt);
    let mut simulation = Simulation::new(scene).unwrap();
    let mut ended = None;
    while !simulation.done() && ended.is_none() {
        ended = simulation.step().err();
    }
    let message = ended.map_or(String::new(), |fault| fault.to_string());
    assert!(message.contains("push each other too far"), "{message}");
    let bodies = &simulation.state().unwrap().bodies;
    assert!(bodies.velocity.iter().all(|v| v.length() * dt < longest), "{:?}", bodies.velocity);
}
