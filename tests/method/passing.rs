//! Bodies that a step takes through each other are told, and nothing else is.

use glam::{DQuat, DVec3};
use relcp::internals::dynamics::{Pose, Twist, advance};
use relcp::internals::step::passed;
use relcp::scene::Scene;
use relcp::separation::{Placed, separation};
use relcp::simulation::Simulation;
use relcp::step::Passed;
use std::path::Path;

fn torn_chain(sets: &[&str]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/torn-chain.json");
    let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
    Scene::load(path.to_str().unwrap(), &sets).unwrap()
}

/// Each step's passage.
fn passages(scene: Scene) -> Vec<Option<Passed>> {
    let mut simulation = Simulation::new(scene).unwrap();
    let mut found = Vec::new();
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= 1e-5 && report.unconverged == 0, "{report:?}");
        found.push(report.passed);
    }
    found
}

#[test]
fn rings_that_come_apart_within_tolerance_are_told_of_in_that_step() {
    // Torn so fast that a 64th of the step is too long as well.
    let fast = ["contact.on_failure=continue", "time.dt=20", "time.end=100"];
    let found = passages(torn_chain(&fast));
    assert!(found[0].is_some(), "{found:?}");
    assert_eq!(found.last().unwrap(), &None, "once apart, none passes: {found:?}");
    // At a fifth of the way a step the chain holds, and nothing is said.
    let found = passages(torn_chain(&["time.dt=0.01"]));
    assert!(found.iter().all(Option::is_none), "{found:?}");
}

#[test]
fn rods_at_speeds_that_the_paper_steps_at_do_not_pass() {
    for (name, sets) in [("colony", ["time.end=5", "time.dt=0.01"]), ("compaction", ["time.end=2", "time.dt=0.1"])] {
        let scene = Scene::load(name, sets.map(String::from)).unwrap();
        assert!(passages(scene).iter().all(Option::is_none), "{name}");
    }
}

/// Two random bodies on random ways: what is told agrees with a fine sampling of the way.
#[test]
fn a_passage_is_what_a_fine_sampling_of_the_way_shows() {
    let mut random = crate::random::Random::new(5);
    let (mut told, mut near) = (0, 0);
    let kinds = ["sphere", "spherocylinder", "ellipsoid", "torus"];
    for k in 0..400 {
        let mut start = relcp::bodies::Bodies::default();
        let mut twist = Vec::new();
        for (side, kind) in [(-1.0, kinds[k % 4]), (1.0, kinds[k / 4 % 4])] {
            let position = 1.5 * side * DVec3::X + random.vector();
            let orientation = DQuat::from_axis_angle(random.direction(), random.within(0.0, 3.0));
            start.push(Placed { shape: random.shape(kind), position, orientation }, 0);
            let linear = -3.0 * side * DVec3::X + 2.0 * random.vector();
            twist.push(Twist { linear, angular: 2.0 * random.vector() });
        }
        // A ring has no separation from an ellipsoid.
        if separation(&start.placed(0), &start.placed(1), None).is_none() {
            continue;
        }
        let depth = |s: f64| {
            let [a, b] = [0, 1].map(|i| {
                let from = Pose { position: start.position[i], orientation: start.orientation[i] };
                let Pose { position, orientation } = advance(from, twist[i], s);
                Placed { shape: start.shape[i], position, orientation }
            });
            -separation(&a, &b, None).unwrap().separation
        };
        let samples: Vec<f64> = (0..=400).map(|k| depth(f64::from(k) / 400.0)).collect();
        let thickness = start.shape[0].thickness().min(start.shape[1].thickness());
        let deeper = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max) - samples[0].max(samples[400]).max(0.0);
        let found = passed(&start, &twist, (1.0, None), &[], |a, b| separation(a, b, None)).is_some();
        told += u32::from(found);
        // The bar is three quarters of a thickness; what is just over it for a moment may be missed.
        near += u32::from((0.7..0.85).contains(&(deeper / thickness)));
        assert!(!found || deeper > 0.74 * thickness, "{deeper} of {thickness}");
        assert!(found || deeper < 0.85 * thickness, "{deeper} of {thickness}");
    }
    println!("{told} of 400 pass, {near} are close to the bar");
    assert!(told > 40 && told < 360 && near < 40);
}
