//! Steps in periodic space: overlaps through boundaries, independence of the cell's place, bits.

use crate::{audit, suspension};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::bodies::Bodies;
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::freedom::SPATIAL;
use relcp::internals::step::Verbs;
use relcp::scene::Scene;
use relcp::separation::Placed;
use relcp::shape::Shape;
use relcp::simulation::{Compute, Simulation};
use relcp::step::{Fault, State};

/// Steps a scene from `bodies` to its end; each step is audited by every image of every pair. Returns the recursions,
/// the rows and the largest overlap.
fn run(scene: &Scene, bodies: Bodies) -> (Bodies, Vec<u32>, Vec<usize>, f64) {
    run_to(scene, bodies, true)
}

/// As [`run`]; `pairs_alone` says whether the overlap that a step reports is one of two bodies.
fn run_to(scene: &Scene, bodies: Bodies, pairs_alone: bool) -> (Bodies, Vec<u32>, Vec<usize>, f64) {
    let (mut recursions, mut rows, mut worst) = (Vec::new(), Vec::new(), 0.0_f64);
    let mut simulation = Simulation::builder(scene.clone()).bodies(bodies).build().unwrap();
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert_eq!(report.unconverged, 0, "step {}", report.step);
        let audited = audit(&simulation.state().unwrap().bodies);
        assert!(audited <= scene.contact.overlap_tolerance, "step {}: {audited:e}", report.step);
        let agrees = audited - report.max_overlap;
        assert!(agrees < 1e-12 && (agrees > -1e-12 || !pairs_alone), "step {}: {audited:e} {report:?}", report.step);
        recursions.push(report.recursions);
        rows.push(report.constraints);
        worst = worst.max(audited);
    }
    (simulation.state().unwrap().bodies.clone(), recursions, rows, worst)
}

#[test]
fn a_dense_suspension_holds_the_tolerance_through_its_boundaries() {
    for shape in ["ellipsoid", "rod", "planar"] {
        let scene = suspension(shape);
        let bodies = scene.build().unwrap();
        let start = audit(&bodies);
        let (after, recursions, rows, worst) = run(&scene, bodies.clone());
        let crossed = (0..after.len()).filter(|&i| {
            let cell = |bodies: &Bodies| after.periods.wrapped(bodies.position[i]).1;
            cell(&after) != cell(&bodies)
        });
        let crossed = crossed.count();
        println!(
            "{shape}: start {start:.2e}, worst {worst:.2e}, recursions {}, rows {:?}, {crossed} crossed",
            recursions.iter().sum::<u32>(),
            rows.last()
        );
        assert!(crossed >= 3, "{shape}: {crossed} bodies have crossed a boundary");
        assert!(rows.last().is_some_and(|rows| *rows >= 15), "{shape}: {rows:?}");
    }
}

#[test]
fn a_crowd_that_starts_in_overlap_is_parted_in_one_step() {
    let text = r#"{"name": "crowd", "time": {"dt": 0.02, "end": 0.1}, "periodic": {"lengths": [8.0, 8.0, 8.5]},
        "forces": [{"uniform": {"force": [0.0, 0.0, -1.0]}}], "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [0.0, 0.0, 0.0]}]}"#;
    let scene = Scene::parse(text, "crowd").unwrap();
    let mut bodies = scene.build().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let shapes = [
        Shape::Ellipsoid { radii: [0.6, 0.9, 1.3] },
        Shape::Spherocylinder { diameter: 0.9, length: 3.4 },
        Shape::Sphere { radius: 0.9 },
    ];
    for i in 0..60 {
        let mut draw = || 2.0 * DVec3::from(random.random::<[f64; 3]>()) - 1.0;
        let orientation = DQuat::from_rotation_arc(DVec3::Z, draw().normalize());
        bodies.push(Placed { shape: shapes[i % 3], position: 20.0 * draw(), orientation }, 0);
    }
    let start = audit(&bodies);
    let (_, recursions, rows, worst) = run(&scene, bodies);
    println!("start {start:.2}, worst {worst:.2e}, recursions {recursions:?}, rows {rows:?}");
    assert!(start > 0.5 && rows[0] > 150, "{start} {rows:?}");
}

/// The farthest that two states' bodies are apart, whatever cells they are in, after `by` is taken off the second.
fn farthest(a: &Bodies, b: &Bodies, by: DVec3) -> f64 {
    let apart = |i: usize| {
        let turned = 1.0 - a.orientation[i].dot(b.orientation[i]).abs();
        a.periods.nearest(b.position[i] - by - a.position[i]).length().max(turned)
    };
    (0..a.len()).map(apart).fold(0.0, f64::max)
}

#[test]
fn the_outcome_does_not_depend_on_where_the_cell_is_or_on_the_images_of_bodies() {
    for shape in ["ellipsoid", "rod", "planar"] {
        let mut scene = suspension(shape);
        // What a solve leaves open is the rounding's to fill.
        scene.solver.tolerance = Some(1e-10);
        let bodies = scene.build().unwrap();
        let (after, recursions, rows, _) = run(&scene, bodies.clone());
        let length = bodies.periods.length();
        let by = DVec3::new(0.37, -1.91, if scene.planar { 0.0 } else { 5.43 }) * length.max_element();
        let mut moved = bodies.clone();
        for (i, x) in moved.position.iter_mut().enumerate() {
            let cells = DVec3::new([0.0, 1.0, -3.0][i % 3], [2.0, 0.0][i % 2], [0.0, 0.0, 0.0, -1.0][i % 4]);
            *x += by + length * cells;
        }
        let (shifted, recursions_shifted, rows_shifted, _) = run(&scene, moved);
        let apart = farthest(&after, &shifted, by);
        println!("{shape}: {apart:.2e} apart");
        assert!(apart < 1e-8, "{shape}: {apart:e}");
        assert_eq!((recursions_shifted, rows_shifted), (recursions, rows), "{shape}");
    }
}

#[test]
fn a_jump_of_a_thousand_cells_between_steps_changes_nothing() {
    let scene = suspension("rod");
    let resume = |state: State| Simulation::builder(scene.clone()).resume(state).build().unwrap();
    let fresh = || Simulation::new(scene.clone()).unwrap();
    let (mut straight, mut jumps) = (fresh(), fresh());
    for step in 0..10 {
        let (one, other) = (straight.step().unwrap(), jumps.step().unwrap());
        assert_eq!((one.recursions, one.constraints), (other.recursions, other.constraints), "step {step}");
        if step == 4 {
            let mut state = jumps.state().unwrap().clone();
            let length = state.bodies.periods.length();
            state.bodies.position.iter_mut().step_by(4).for_each(|x| *x += 1000.0 * length);
            state.bodies.position.iter_mut().skip(1).step_by(4).for_each(|x| x.y -= 1000.0 * length.y);
            jumps = resume(state);
        }
    }
    let apart = farthest(&straight.state().unwrap().bodies, &jumps.state().unwrap().bodies, DVec3::ZERO);
    println!("{apart:.2e} apart");
    assert!(apart < 1e-9, "{apart:e}");
}

#[test]
fn threads_and_resumption_leave_the_bits_as_they_are() {
    let scene = suspension("ellipsoid");
    let steps = |threads: usize, resumed: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = Simulation::new(scene.clone()).unwrap();
            for step in 0..12 {
                simulation.step().unwrap();
                if resumed && step == 6 {
                    let state = simulation.state().unwrap();
                    let bytes = relcp::record::encode(state, "x", 0.0, Some(&Default::default())).unwrap();
                    simulation = Simulation::builder(scene.clone())
                        .resume(relcp::record::decode(&bytes).unwrap().1)
                        .build()
                        .unwrap();
                }
            }
            simulation.state().unwrap().clone()
        })
    };
    let one = steps(1, false);
    assert!(!one.bodies.periods.is_none());
    assert_eq!(steps(3, false), one);
    assert_eq!(steps(2, true), one);
}

#[test]
fn two_spheres_meet_through_the_boundary_as_they_do_in_the_middle() {
    let at = |x: f64, y: f64, group: &str| {
        format!(r#"{{"shape": {{"sphere": {{"radius": 0.5}}}}, "position": [{x}, {y}, 0.0], "group": "{group}"}}"#)
    };
    let scene = |a: &str, b: &str, periodic: &str| {
        let text = format!(
            r#"{{"name": "two", "time": {{"dt": 0.05, "end": 1.0}}, {periodic} "forces": [
            {{"uniform": {{"force": [1.0, 0.0, 0.0], "group": "l"}}}}, {{"uniform": {{"force": [-1.0, 0.1, 0.0], "group": "r"}}}}],
            "bodies": [{a}, {b}]}}"#
        );
        Scene::parse(&text, "two").unwrap()
    };
    let open = scene(&at(-1.0, 0.0, "l"), &at(1.0, 0.3, "r"), "");
    let through = scene(&at(4.0, 0.0, "l"), &at(-4.0, 0.3, "r"), r#""periodic": {"lengths": [10.0, null, null]},"#);
    let (alone, ..) = run(&open, open.build().unwrap());
    let (met, ..) = run(&through, through.build().unwrap());
    for i in 0..2 {
        let by = alone.position[i] - (met.position[i] - DVec3::X * [5.0, -5.0][i]);
        assert!(by.length() < 1e-12, "{by}");
        assert!(alone.orientation[i].abs_diff_eq(met.orientation[i], 1e-12));
    }
    // Without the period they part.
    let mut parted = through;
    parted.periodic = None;
    let (parted, ..) = run(&parted, parted.build().unwrap());
    assert!((parted.position[0].x - met.position[0].x).abs() > 0.3);
}

#[test]
fn a_channel_across_a_periodic_axis_holds_bodies_that_go_round() {
    for stepping in ["euler", "midpoint"] {
        let text = format!(
            r#"{{"name": "flow", "seed": 2, "dynamics": {{"inertial": {{"density": 1.0}}}}, "time": {{"dt": 0.02, "end": 2.0, "stepping": "{stepping}"}},
            "periodic": {{"lengths": [9.0, null, 9.0]}}, "walls": [{{"channel": {{"normal": [0, 1, 0], "center": [0, 0, 0], "width": 5.0}}}}],
            "forces": [{{"gravity": {{"acceleration": [4.0, -1.0, 0.0]}}}}],
            "generate": [{{"isotropic": {{"count": 20, "shape": {{"spherocylinder": {{"diameter": 1.0, "length": 3.5}}}}, "volume_fraction": 0.1}}}}]}}"#
        );
        let scene = Scene::parse(&text, "flow").unwrap();
        let (after, _, _, worst) = run_to(&scene, scene.build().unwrap(), false);
        let past = scene.walls().max_overlap(&after);
        let rounds = after.position.iter().filter(|x| x.x > 4.5).count();
        println!("{stepping}: worst {worst:.2e}, {past:.2e} past the walls, {rounds} of 20 went round");
        assert!(past <= 1e-5 && rounds >= 10, "{past:e} {rounds}");
        assert!(scene.walls().contacts(&after, 1e-3).len() >= 3);
    }
}

/// The rows of a pair that meets through a boundary are those of the same pair that meets in the open.
#[test]
fn rows_have_the_levers_of_the_image() {
    let rod = |x: f64, y: f64, turn: f64| {
        format!(
            r#"{{"shape": {{"ellipsoid": {{"radii": [0.5, 0.7, 1.5]}}}}, "position": [{x}, {y}, 0.0], "orientation": [1.0, {turn}, 0.3, 0.1]}}"#
        )
    };
    let rows = |bodies: &str, periodic: &str| {
        let text = format!(
            r#"{{"name": "pair", "time": {{"dt": 0.1, "end": 1.0}}, "contact": {{"cutoff": 0.5}}, {periodic}
            "forces": [{{"uniform": {{"force": [0.3, 0.2, 0.1]}}}}], "bodies": [{bodies}]}}"#
        );
        let scene = Scene::parse(&text, "pair").unwrap();
        let state = State { bodies: scene.build().unwrap(), ..State::default() };
        let mut backend = Cpu::<SPATIAL>::new(&scene.model(), state).unwrap();
        backend.begin().unwrap();
        backend.append_near().unwrap();
        let (problem, _) = backend.lcp();
        (problem.pair.clone(), problem.jacobian.clone(), problem.q.clone())
    };
    let (pairs, jacobian, q) = rows(&format!("{}, {}", rod(0.0, 0.0, 0.2), rod(1.1, 0.4, 1.4)), "");
    assert_eq!(pairs, [[0, 1]]);
    let arms =
        jacobian[0].iter().map(|block| block[3..].iter().map(|x| x.abs()).fold(0.0, f64::max)).fold(0.0, f64::max);
    assert!(arms > 0.01, "levers count: {jacobian:?}");
    for (x, y) in [(1.1 - 9.0, 0.4), (1.1 + 27.0, 0.4 - 16.0), (1.1 - 9e5, 0.4 + 8e5)] {
        let periodic = r#""periodic": {"lengths": [9.0, 8.0, null]},"#;
        let (through, image, offset) = rows(&format!("{}, {}", rod(0.0, 0.0, 0.2), rod(x, y, 1.4)), periodic);
        assert_eq!(through, pairs);
        let rounding = 1e-14 + 8.0 * f64::EPSILON * x.abs();
        assert!((offset[0] - q[0]).abs() < rounding, "{x}: {:e}", offset[0] - q[0]);
        for (one, other) in image[0].as_flattened().iter().zip(jacobian[0].as_flattened()) {
            assert!((one - other).abs() < rounding, "{x}: {one} {other}");
        }
    }
}

#[test]
fn cells_divide_and_push_their_own_kind_through_the_boundary() {
    let text = r#"{"name": "cells", "seed": 3, "planar": true, "time": {"dt": 0.02, "end": 3.0}, "periodic": {"lengths": [9.0, 14.0, null]},
        "growth": {"rate": 1.0, "division_length": 4.0, "reorientation_degrees": 5.0, "stress_sensitivity": 0.001, "stop": {"population": 24}},
        "generate": [{"founder": {"diameter": 0.5, "length": 2.0}}]}"#;
    let scene = Scene::parse(text, "cells").unwrap();
    for stepping in ["euler", "midpoint"] {
        let scene =
            Scene::parse(&text.replace(r#""end": 3.0"#, &format!(r#""end": 3.6, "stepping": "{stepping}""#)), "cells")
                .unwrap();
        let (after, _, rows, worst) = run(&scene, scene.build().unwrap());
        let outside = after.position.iter().filter(|x| x.x.abs() > 4.5).count();
        println!("{stepping}: {} cells, {outside} outside, {:?} rows, worst {worst:.2e}", after.len(), rows.last());
        assert!(after.len() >= 24 && outside >= 1, "{} cells, {outside} outside", after.len());
    }
    // Long enough in the open for its ends to meet; refused where half a period is shorter than a cell grows.
    let short = text.replace("[9.0, 14.0, null]", "[9.0, 8.0, null]");
    let error = Scene::parse(&short, "cells").unwrap_err();
    assert_eq!(error.key(), "periodic.lengths.1");
    assert!(scene.validate().is_ok());
}

#[test]
fn sub_spheres_and_the_other_methods_meet_through_the_boundary() {
    for (method, most) in [("{\"multisphere\": {\"count\": 5}}", 0.3), ("\"snsd\"", 0.05)] {
        let mut scene = suspension("rod");
        scene =
            Scene::parse(&scene.to_json().replace("\"method\": \"relcp\"", &format!("\"method\": {method}")), "rods")
                .unwrap();
        let mut simulation = Simulation::new(scene.clone()).unwrap();
        for _ in 0..15 {
            simulation.step().unwrap();
        }
        let audited = audit(&simulation.state().unwrap().bodies);
        println!("{method}: {audited:.2e}");
        assert!(audited < most, "{method}: {audited}");
    }
}

#[test]
fn a_step_that_leaps_over_images_and_bodies_out_of_sight_are_faults() {
    let text = |force: f64, x: f64| {
        format!(
            r#"{{"name": "far", "time": {{"dt": 1.0, "end": 3.0}}, "periodic": {{"lengths": [4.0, 4.0, 4.0]}},
            "forces": [{{"uniform": {{"force": [{force}, 0.0, 0.0]}}}}],
            "bodies": [{{"shape": {{"sphere": {{"radius": 0.25}}}}, "position": [{x}, 0.0, 0.0]}}]}}"#
        )
    };
    let step = |text: &str, by: f64| {
        let scene = Scene::parse(text, "far").unwrap();
        let mut bodies = scene.build().unwrap();
        bodies.position[0].x += by;
        let mut simulation = Simulation::builder(scene).bodies(bodies).on(&Compute::Cpu).build().unwrap();
        simulation.step().map(|report| report.max_overlap)
    };
    assert_eq!(step(&text(0.2, 0.0), 0.0), Ok(0.0));
    assert!(matches!(step(&text(1000.0, 0.0), 0.0), Err(Fault::PeriodTooShort { step: 1, body: 0, .. })));
    assert!(matches!(step(&text(0.2, 0.0), 1e12), Err(Fault::TooFar { step: 1, body: 0 })));
    // A body of one's own that is longer than the scene's.
    let scene = Scene::parse(&text(0.2, 0.0), "far").unwrap();
    let mut bodies = scene.build().unwrap();
    bodies.shape[0] = relcp::shape::Shape::Sphere { radius: 1.5 };
    let fault = Simulation::builder(scene).bodies(bodies).build().unwrap().step().unwrap_err();
    assert!(fault.to_string().contains("half of the period 4;"), "{fault}");
}
