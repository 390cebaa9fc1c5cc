//! Steps that fail: what is accepted of them, what is taken again, and what ends a run.

use glam::DVec3;
use relcp::scene::Scene;
use relcp::simulation::Simulation;
use relcp::step::{Fault, StepReport};
use std::path::Path;

const TOLERANCE: f64 = 1e-5;

fn stored(name: &str, sets: &[&str]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
    Scene::load(path.to_str().unwrap(), &sets).unwrap()
}

fn parsed(text: &str) -> Scene {
    Scene::parse(text, "scene.json").unwrap()
}

fn start(scene: Scene) -> Simulation {
    Simulation::new(scene).unwrap()
}

/// Runs to the end, or to the fault that ends it.
fn run(simulation: &mut Simulation) -> (Vec<StepReport>, Option<Fault>) {
    let mut reports = Vec::new();
    while !simulation.done() {
        match simulation.step() {
            Ok(report) => reports.push(report),
            Err(fault) => return (reports, Some(fault)),
        }
    }
    (reports, None)
}

/// A cell in a disc of radius 1.6, which five or so of its kind fill.
fn small_disc(growth: &str, contact: &str, end: f64) -> Scene {
    parsed(&format!(
        r#"{{ "name": "disc", "planar": true, "seed": 1, "time": {{ "dt": 0.01, "end": {end} }},
        "generate": [ {{ "founder": {{ "diameter": 0.5, "length": 1.0 }} }} ],
        "growth": {{ "rate": 1, "division_length": 2.0, "reorientation_degrees": 2 {growth} }},
        "contact": {{ "overlap_tolerance": 1e-5 {contact} }},
        "walls": [ {{ "sphere": {{ "center": [0, 0, 0], "radius": 1.6 }} }} ] }}"#
    ))
}

#[test]
fn a_colony_in_a_channel_of_eight_diameters_does_not_explode() {
    let (reports, fault) = run(&mut start(stored("full-channel.json", &[])));
    assert_eq!(fault, None);
    for report in &reports {
        assert!(report.within(TOLERANCE) && report.settled(TOLERANCE) && report.passed.is_none(), "{report:?}");
    }
}

#[test]
fn a_chain_that_a_step_tears_holds_in_halves_of_the_step() {
    let mut simulation = start(stored("torn-chain.json", &[]));
    let (reports, fault) = run(&mut simulation);
    assert_eq!(fault, None);
    assert!(reports.iter().all(|report| report.passed.is_none() && report.within(TOLERANCE)));
    assert!(reports[0].pieces > 1 && reports[0].failed_attempts > 0, "{:?}", reports[0]);
    assert_eq!(simulation.steps(), reports.len() as u64, "pieces are no steps");
}

#[test]
fn a_step_in_pieces_has_the_same_bits_on_any_number_of_threads() {
    let end = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = start(stored("torn-chain.json", &["time.end=0.1"]));
            let (reports, _) = run(&mut simulation);
            (reports[0].pieces, simulation.state().unwrap().clone())
        })
    };
    let (pieces, state) = end(1);
    assert!(pieces > 1);
    assert_eq!(end(3), (pieces, state));
}

#[test]
fn a_run_goes_on_to_the_same_bits_where_steps_are_taken_in_pieces() {
    let scene = stored("torn-chain.json", &["time.end=0.2"]);
    let mut whole = start(scene.clone());
    whole.step().unwrap();
    let between = whole.state().unwrap().clone();
    run(&mut whole);
    let mut resumed = Simulation::builder(scene).resume(between).build().unwrap();
    run(&mut resumed);
    assert_eq!(resumed.state().unwrap(), whole.state().unwrap());
}

#[test]
fn a_full_disc_ends_the_run_with_the_state_before_and_says_so() {
    let mut simulation = start(small_disc("", "", 5.0));
    let (reports, fault) = run(&mut simulation);
    let Some(Fault::NoRoom { bodies, wedge, unresolved }) = fault else { panic!("{fault:?}") };
    assert!(wedge.bodies.len() > 1 && wedge.bodies.iter().all(|body| *body < bodies), "{wedge:?}");
    assert_eq!((bodies, unresolved.step), (simulation.bodies(), simulation.steps() + 1));
    assert!(reports.iter().all(|report| report.within(TOLERANCE)));
    let said = Fault::NoRoom { bodies, wedge, unresolved }.to_string();
    assert!(said.starts_with("no room: cells ") && said.contains("growth.on_no_room"), "{said}");
    // It stands at an accepted state, and says the same again.
    assert_eq!(simulation.state().unwrap().step, reports.len() as u64);
    assert!(matches!(simulation.step(), Err(Fault::NoRoom { .. })));
}

#[test]
fn cells_that_have_no_room_wait_and_nothing_overlaps() {
    let mut simulation = start(small_disc(r#", "on_no_room": "stall""#, "", 4.0));
    let (reports, fault) = run(&mut simulation);
    assert_eq!(fault, None);
    assert!(reports.iter().all(|report| report.within(TOLERANCE) && report.settled(TOLERANCE)));
    assert!(reports.last().unwrap().waiting > 0, "{:?}", reports.last());
    // Full: the cells' area is most of the disc's, and it stays.
    let bodies = &simulation.state().unwrap().bodies;
    let area = |length: f64| std::f64::consts::PI / 16.0 + (length - 0.5) * 0.5;
    let covered: f64 = bodies.shape.iter().map(|shape| area(shape.growing_length().unwrap())).sum();
    let part = covered / (std::f64::consts::PI * 1.6 * 1.6);
    assert!(part > 0.6 && part < 0.95, "{part}");
}

#[test]
fn cells_that_must_grow_in_a_full_disc_overlap_and_none_is_thrown() {
    let mut simulation = start(small_disc("", r#", "on_failure": "continue""#, 3.0));
    let (reports, fault) = run(&mut simulation);
    assert_eq!(fault, None);
    let over = reports.iter().filter(|report| !report.within(TOLERANCE)).count();
    assert!(over > 0, "the disc is not full");
    let state = simulation.state().unwrap();
    assert!(state.bodies.position.iter().all(|x| x.length() < 1.6), "{:?}", state.bodies.position);
    let worst = reports.iter().map(|report| report.max_overlap).fold(0.0, f64::max);
    println!("largest overlap {worst:.3}, {over} steps over");
    // By then the cells cover more than the disc.
    assert!(worst < 0.9, "{worst}");
}

/// Thirteen spheres in a flat box that has room for nine.
const HELD: &str = r#"{ "name": "held", "time": { "dt": 0.01, "end": 0.05 }, CONTACT
    "walls": [ { "box": { "minimum": [-1.6, -1.6, -0.5], "maximum": [1.6, 1.6, 0.5] } } ],
    "bodies": [ { "shape": { "sphere": { "radius": 0.48 } }, "position": [0, 0, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [0.9, 0, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [-0.9, 0, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [0, 0.9, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [0, -0.9, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [0.9, 0.9, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [-0.9, 0.9, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [0.9, -0.9, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [-0.9, -0.9, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [1.1, 0.45, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [-1.1, 0.45, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [0.45, 1.1, 0] },
                { "shape": { "sphere": { "radius": 0.48 } }, "position": [0.45, -1.1, 0] } ] }"#;

#[test]
fn spheres_in_a_box_that_is_too_small_stop_the_run_with_the_pair_and_what_to_do() {
    let scene = parsed(&HELD.replace("CONTACT", ""));
    let mut simulation = start(scene);
    let before = simulation.state().unwrap().clone();
    let fault = simulation.step().unwrap_err();
    let Fault::Unresolved(unresolved) = &fault else { panic!("{fault:?}") };
    assert!(unresolved.pair.is_some() || unresolved.wall.is_some(), "{unresolved:?}");
    assert_eq!(fault.name(), "overlap");
    assert!(fault.to_string().contains("contact.on_failure"), "{fault}");
    assert_eq!(simulation.state().unwrap(), &before, "the state is the one before the step");
}

#[test]
fn spheres_in_a_box_that_is_too_small_share_the_overlap_where_the_run_goes_on() {
    let mut simulation = start(parsed(&HELD.replace("CONTACT", r#""contact": { "on_failure": "continue" },"#)));
    let (reports, fault) = run(&mut simulation);
    assert_eq!(fault, None);
    let last = reports.last().unwrap();
    assert!(!last.within(TOLERANCE) && last.max_overlap < 0.48, "{last:?}");
    let bodies = &simulation.state().unwrap().bodies;
    assert!(bodies.position.iter().all(|x| x.abs().max_element() < 1.6), "{:?}", bodies.position);
}

#[test]
fn a_start_that_overlaps_gives_bodies_with_inertia_no_speed() {
    let text = r#"{ "name": "grown-together", "dynamics": { "inertial": { "density": 1 } }, "time": { "dt": 0.001, "end": 0.02 },
        "bodies": [ { "shape": { "sphere": { "radius": 0.5 } }, "position": [0, 0, 0], "velocity": [0, 0.1, 0] },
                    { "shape": { "spherocylinder": { "diameter": 0.5, "length": 2 } }, "position": [0.4, 0, 0] },
                    { "shape": { "ellipsoid": { "radii": [0.3, 0.4, 0.8] } }, "position": [-0.3, 0.1, 0] } ] }"#;
    let mut simulation = start(parsed(text));
    let (reports, fault) = run(&mut simulation);
    assert_eq!(fault, None);
    assert!(reports[0].parted && reports.iter().all(|report| report.within(TOLERANCE)));
    let fastest = |v: &DVec3| v.length();
    let bodies = &simulation.state().unwrap().bodies;
    let speed = bodies.velocity.iter().map(fastest).fold(0.0, f64::max);
    assert!(speed <= 0.11, "{speed}");
}

#[test]
fn a_solve_that_ends_early_in_a_step_within_tolerance_is_a_note() {
    let scene = stored("full-channel.json", &["solver.kind=pair_block_cg"]);
    let mut simulation = start(scene);
    let (reports, fault) = run(&mut simulation);
    assert_eq!(fault, None);
    let mut totals = relcp::record::Totals::default();
    for report in &reports {
        totals.add(report, TOLERANCE, std::time::Duration::ZERO);
    }
    // One whose solve ended early, with a residual over the solver's tolerance and under the other.
    let mut early = reports[0];
    (early.unconverged, early.residual, early.velocity_residual) = (1, 0.5 * TOLERANCE, 0.5 * TOLERANCE);
    totals.add(&early, TOLERANCE, std::time::Duration::ZERO);
    assert!(totals.unconverged > 0);
    assert_eq!((totals.clean(), totals.reason()), (true, None));
}

#[test]
fn a_dish_that_is_full_at_once_ends_the_run_without_a_panic_of_the_solver() {
    for radius in [1.0, 1.05, 1.1, 1.2] {
        let walls = format!(r#"walls=[{{"cylinder":{{"center":[0,0,0],"axis":[0,0,1],"radius":{radius}}}}}]"#);
        let scene = Scene::load("colony", ["time.dt=0.02", "time.end=0.7", &walls]).unwrap();
        let mut simulation = Simulation::new(scene).unwrap();
        let ended = (0..35).find_map(|_| simulation.step().err());
        assert!(matches!(ended, Some(Fault::NoRoom { .. })), "{radius}: {ended:?}");
    }
}
