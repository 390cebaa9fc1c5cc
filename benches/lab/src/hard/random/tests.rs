use super::watch::Watch;
use super::*;
use crate::hard::Verdict;
use crate::hard::start::{Start, heap, moving, rod, sphere, upright};
use relcp::scene::{Dynamics, Force, Scene};
use relcp::simulation::{Compute, Simulation};
use std::collections::BTreeSet;

/// Seeds of which every scene must be taken.
const MANY: u64 = 300;

#[test]
fn every_scene_of_a_seed_is_accepted_and_can_be_read_back() {
    for number in 0..MANY {
        let drawn = random(7, number).unwrap();
        assert!(drawn.scene.build().is_ok_and(|bodies| !bodies.is_empty()), "{number}");
        assert_eq!(Scene::parse(&drawn.scene.to_json(), "again").unwrap(), drawn.scene, "{number}");
        let steps = drawn.scene.time.steps();
        assert!((1..=400).contains(&steps) && drawn.scene.bodies.len() <= 60, "{}", drawn.what);
    }
    for drawn in (0..MANY).flat_map(|number| [confined(7, number).unwrap(), pressed(7, number).unwrap()]) {
        assert_eq!(Scene::parse(&drawn.scene.to_json(), "again").unwrap(), drawn.scene, "{}", drawn.scene.name);
    }
}

/// The page refers to scenes by their seed and number.
#[test]
fn scenes_of_a_seed_stay_what_they_are() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/studies/hard/random.md");
    let page = std::fs::read_to_string(file).unwrap();
    let mut known = 0;
    for line in page.lines() {
        let mut cells = line.split(" | ");
        let Some(name) = cells.next().and_then(|cell| cell.strip_prefix("| ")) else { continue };
        let mut parts = name.split('-');
        let kind = parts.next().unwrap();
        let [Some(seed), Some(number)] = [0; 2].map(|_| parts.next().and_then(|digits| digits.parse().ok())) else {
            continue;
        };
        let drawn = if kind == "random" { random(seed, number) } else { confined(seed, number) }.unwrap();
        assert_eq!((drawn.scene.name.as_str(), Some(drawn.what.as_str())), (name, cells.next()));
        known += 1;
    }
    assert!(known >= 10, "{known}");
}

#[test]
fn everything_that_presses_is_drawn() {
    let drawn: Vec<Drawn> = (0..MANY).map(|number| pressed(7, number).unwrap()).collect();
    let count = |word: &str| drawn.iter().filter(|drawn| drawn.what.contains(word)).count();
    let words = [
        "a trap ",
        "tilted floor",
        "narrows",
        "widens",
        "a corner",
        "stalls",
        "flat in space",
        "piston",
        "plates",
        "box that closes",
        "balls,",
        "rods end to end",
        "tip to tip",
        "face to face",
        "in line",
        "between sides",
        "discs to",
        "fall on",
        "gap",
        "in a tube",
        "in a channel",
        "without slack",
        "planar",
        "spatial",
        "inertial",
        "overdamped",
        "midpoint",
    ];
    let missing: Vec<&str> = words.into_iter().filter(|word| count(word) < 2).collect();
    assert_eq!(missing, [""; 0]);
    let bodies = drawn.iter().map(|drawn| drawn.scene.bodies.len()).max();
    let steps = drawn.iter().filter(|drawn| drawn.scene.growth.is_empty()).map(|drawn| drawn.scene.time.steps()).max();
    assert!(bodies <= Some(60) && steps <= Some(400), "{bodies:?} {steps:?}");
}

#[test]
fn everything_that_a_scene_may_have_is_drawn() {
    let scenes: Vec<Scene> = (0..MANY).map(|number| random(7, number).unwrap().scene).collect();
    let kinds = |of: &dyn Fn(&Scene) -> Vec<&'static str>| scenes.iter().flat_map(of).collect::<BTreeSet<_>>();
    let walls = kinds(&|scene| scene.walls.iter().map(|wall| wall.name()).collect());
    assert_eq!(walls, BTreeSet::from(["half_space", "channel", "box", "sphere", "cylinder"]));
    let shapes = kinds(&|scene| scene.bodies.iter().map(|body| body.shape.name()).collect());
    assert_eq!(shapes, BTreeSet::from(["sphere", "spherocylinder", "ellipsoid", "torus"]));
    let count = |of: &dyn Fn(&Scene) -> bool| scenes.iter().filter(|scene| of(scene)).count();
    let inertial = count(&|scene| matches!(scene.dynamics, Dynamics::Inertial { .. }));
    let common = [
        count(&|scene| scene.planar),
        inertial,
        scenes.len() - inertial,
        count(&|scene| scene.time.stepping == relcp::scene::Stepping::Midpoint),
        count(&|scene| scene.walls.len() > 1),
    ];
    assert!(common.iter().all(|count| *count >= 30), "{common:?}");
    let rare = [
        count(&|scene| scene.growth.iter().any(|growth| growth.stress_sensitivity > 0.0)),
        count(&|scene| scene.periodic.is_some() && !scene.walls.is_empty()),
        count(&|scene| scene.forces.iter().any(|force| matches!(force, Force::RadialOutward { .. }))),
        count(&|scene| scene.forces.iter().any(|force| matches!(force, Force::Gravity { group: Some(_), .. }))),
        count(&|scene| scene.contact != relcp::scene::ContactSettings::default()),
    ];
    assert!(rare.iter().all(|count| *count >= 3), "{rare:?}");
}

#[test]
fn drawn_scenes_get_the_same_rows_on_any_number_of_threads_and_none_fails() {
    let tickets = Ticket::of([25, 4, 0], 0);
    let options =
        |threads: usize| Options { seed: 1, threads, most_steps: 12, rough: false, keys: false, compute: Compute::Cpu };
    let rows = run_all(&tickets, &options(2), &|_| ()).unwrap();
    assert_eq!(rows, run_all(&tickets, &options(1), &|_| ()).unwrap());
    let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!((names.len(), names[0], names[28]), (29, "random-1-0", "confined-1-3"));
    let failing: Vec<&Row> = rows.iter().filter(|row| row.verdict == Verdict::Fails).collect();
    assert_eq!(failing, [] as [&Row; 0]);
    for row in &rows {
        assert_eq!(row.why.is_empty(), row.verdict == Verdict::Holds);
        assert_eq!(row.scene.is_some(), row.verdict != Verdict::Holds, "{}", row.name);
    }
    let page = page(&rows, 1, "--seed 1", "CPU f64");
    assert!(page.contains("25 scenes, ") && page.contains("4 scenes, "), "{page}");
    assert_eq!(String::from_utf8(csv(&rows).unwrap()).unwrap().lines().count(), 1 + rows.len());
}

#[test]
fn pressed_bodies_get_the_same_rows_on_any_number_of_threads() {
    let tickets = Ticket::of([0, 0, 12], 0);
    let options =
        |threads: usize| Options { seed: 1, threads, most_steps: 8, rough: false, keys: false, compute: Compute::Cpu };
    let rows = run_all(&tickets, &options(2), &|_| ()).unwrap();
    assert_eq!(rows, run_all(&tickets, &options(1), &|_| ()).unwrap());
    assert!(rows.iter().all(|row| row.from == From::Pressed && row.name.starts_with("pressed-1-")), "{rows:?}");
    let jumps = |row: &Row| row.measures.iter().any(|measure| measure.what.starts_with("move of"));
    assert!(rows.iter().all(jumps), "{rows:?}");
    assert!(page(&rows, 1, "--seed 1", "CPU f64").contains("## Pressed bodies\n\n12 scenes, "));
}

#[test]
fn a_step_over_the_tolerance_ends_the_run() {
    // Without recursion rods that lie across each other are not parted; the method promises no tolerance, so it is
    // reported.
    let mut start = Start::still(0.01, heap(3, &[rod(0.3, 2.0)], 20, 1.0));
    start.scene.contact.method = relcp::scene::Method::Snsd;
    let drawn = Drawn { what: "a heap".into(), scene: start.scene };
    let row = run(From::Random, drawn, 5, &Compute::Cpu);
    assert_eq!((row.verdict, row.figures.steps), (Verdict::Reported, 1), "{row:?}");
    assert_eq!(row.why[0].kind, "over the tolerance");
}

fn watched(start: &Start, change: impl Fn(&mut Simulation) -> bool, steps: usize) -> Watch {
    let mut watch = Watch::new(From::Random, &start.scene);
    let mut simulation = Simulation::new(start.scene.clone()).unwrap();
    for _ in 0..steps {
        let before = simulation.state().unwrap().bodies.clone();
        simulation.step().unwrap();
        assert!(change(&mut simulation));
        watch.see(&before, &simulation);
    }
    watch
}

#[test]
fn a_body_that_is_thrown_and_energy_from_nowhere_are_seen() {
    // A force that the scene does not tell of.
    let bodies = vec![upright(sphere(0.5), [0.0; 3]), upright(sphere(0.5), [3.0, 0.0, 0.0])];
    let push = |force: f64| {
        move |_: &relcp::bodies::Bodies, i: usize, _: f64| relcp::dynamics::Load {
            force: glam::DVec3::X * if i == 1 { force } else { 0.0 },
            torque: glam::DVec3::ZERO,
        }
    };
    let measured = |start: &Start, force: f64| {
        let pushed = |simulation: &mut Simulation| {
            simulation.add_force(Box::new(push(force)));
            true
        };
        let measures = watched(start, pushed, 3).measures();
        assert_eq!(measures.len(), 1, "{measures:?}");
        measures[0].clone()
    };
    let still = Start::still(0.01, bodies.clone());
    assert!(measured(&still, 0.0).value <= 0.0);
    let thrown = measured(&still, 5e3);
    assert!(thrown.value > thrown.bound, "{thrown:?}");
    let falls: Vec<_> = bodies.into_iter().map(|body| moving(body, [0.0, 1.0, 0.0], [0.0; 3])).collect();
    let mut falling = Start::inertial(0.01, falls);
    falling.scene.forces = vec![Force::Gravity { acceleration: [0.0, 0.0, -9.0], group: None, window: None }];
    let falls = measured(&falling, 0.0);
    assert!(falls.value <= 1e-12, "{falls:?}");
    let driven = measured(&falling, 1e3);
    assert!(driven.value > driven.bound, "{driven:?}");
}
